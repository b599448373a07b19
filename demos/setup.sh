# What demos/run.sh and tests/run.sh share: the packages, and how the project is configured and built. To be sourced.

export PATH # in an empty environment bash has one of its own, which cmake has to be told
project_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Debian 12 names; third_party_notes/ says what each is for. Ninja, ccache and ffmpeg are used where they are found.
# gnuplot-nox is a program that the experiments run.
build_packages=(
    build-essential cmake pkg-config
    libbullet-dev libbullet-extras-dev libeigen3-dev libglm-dev libtbb-dev libzstd-dev
    libegl-dev libgl-dev libegl1 libgl1-mesa-dri libepoxy-dev
    libtomlplusplus-dev libcli11-dev libfmt-dev nlohmann-json3-dev libstb-dev
    liburdfdom-dev libassimp-dev gnuplot-nox
)
# For the window of `bsoil view`: a build without them says that it has none.
viewer_packages=(libsdl2-dev libimgui-dev fonts-dejavu-core)
# For GeoTIFFs of `bsoil export`. OpenVDB is used where it is found: libopenvdb-dev and libboost-dev take 170 MB.
export_packages=(libtiff-dev)
test_packages=(libgtest-dev doxygen clang xvfb xauth)
fuzz_packages=(clang libclang-rt-14-dev)

say() { printf '%s\n' "$*" >&2; }

# install_packages PACKAGE...: installs those that are missing, and leaves apt alone when none is.
install_packages() {
    if ! command -v dpkg-query >/dev/null; then
        say "This is no Debian: what these packages hold has to be installed already: $*"
        return
    fi
    local package missing=() as_root=()
    for package in "$@"; do
        [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || missing+=("$package")
    done
    ((${#missing[@]})) || return 0
    if ((EUID != 0)); then
        as_root=(sudo)
        [[ -t 0 ]] || as_root=(sudo -n) # nobody is there to type a password
        if ! command -v sudo >/dev/null || ! "${as_root[@]}" true; then
            say "Packages are missing, and installing them takes root or sudo:"
            say "    apt-get install --no-install-recommends ${missing[*]}"
            return 1
        fi
    fi
    say "Installing ${missing[*]}"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q >&2 &&
        "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
            apt-get install -q -y --no-install-recommends "${missing[@]}" >&2
}

# configure FOLDER NAME=VALUE...: runs CMake unless the folder is configured with these values already.
# NAME?=VALUE is for a folder that has no value of that name yet.
configure() {
    local folder=$1 entry name configured=0 arguments=()
    shift
    [[ -f $folder/build.ninja || -f $folder/Makefile ]] && configured=1
    for entry in "$@"; do
        if [[ $entry == *\?=* ]]; then
            grep -q "^${entry%%\?=*}:" "$folder/CMakeCache.txt" 2>/dev/null || arguments+=("-D${entry/\?=/=}")
        else
            name=${entry%%=*}
            grep -q "^$name:[A-Z]*=${entry#*=}\$" "$folder/CMakeCache.txt" 2>/dev/null || arguments+=("-D$entry")
        fi
    done
    ((configured && ${#arguments[@]} == 0)) && return
    if ((!configured)) && command -v ninja >/dev/null; then
        arguments+=(-G Ninja)
    fi
    cmake -S "$project_root" -B "$folder" "${arguments[@]}" >&2
}

# build FOLDER [TARGET...]
build() {
    local folder=$1
    shift
    cmake --build "$folder" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" ${1:+--target "$@"} >&2
}
