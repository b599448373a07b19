#!/usr/bin/env bash
# Installs the project and uses it from outside:
#   check_install.sh SOURCE SCRATCH prefix BUILD                installs BUILD
#   check_install.sh SOURCE SCRATCH other_prefix BUILD OPTION...  configures and builds the libraries with the options of
#                                                               cmake, installs them, and the command out of BUILD
#   check_install.sh SOURCE SCRATCH CASE BUILD                  uses what either has installed in SCRATCH
# Programs and files are those that README.md and docs/tutorial.md show. Exit codes: 0 passed, 1 failed.
set -uo pipefail
export LC_ALL=C

source_dir=$1 scratch=$2 test_case=$3
shift 3
prefix=$scratch/prefix
hosts=$source_dir/tests/install/host

fail() {
    printf 'FAIL %s\n' "$*"
    exit 1
}

# must COMMAND...: fails, with all that it printed, where the command fails.
must() {
    local code=0
    "$@" >log 2>&1 || code=$?
    ((code == 0)) && return
    cat log
    fail "exit code $code: $*"
}

# must_fail REGULAR_EXPRESSION COMMAND...: the command fails, and says so.
must_fail() {
    local text=$1
    shift
    "$@" >log 2>&1 && fail "did not fail: $*"
    # CMake breaks its lines
    tr -s ' \n' ' ' <log | grep -qE -- "$text" && return
    cat log
    fail "'$text' is not what this says: $*"
}

# Empties the case's own folder and goes there.
enter() {
    rm -rf "${scratch:?}/$1"
    mkdir -p "$scratch/$1"
    cd "$scratch/$1" || exit 1
}

# page_file NAME [PAGE]: the blocks of a page, README.md by default, that are "tested as NAME", one after the other.
page_file() {
    awk -v mark="<!-- tested as $1 -->" '
        $0 == mark { found = 1; next }
        found && /^```/ { found = !inside; inside = !inside; next }
        inside' "$source_dir/${2:-README.md}"
}

# The library's own path is the host's business: where to find shared ones, and pkg-config's files.
lib=
use_prefix() {
    local config
    config=$(find "$prefix" -name bulletsoil.pc) || exit 1
    [[ -f $config ]] || fail "no bulletsoil.pc in $prefix"
    export PKG_CONFIG_PATH=${config%/*}
    lib=${config%/pkgconfig/*}
    export LD_LIBRARY_PATH=$lib
}

# Builds elsewhere and moves: nothing may depend on where it was.
move_prefix() {
    rm -rf "$prefix"
    mv "$scratch/installed" "$prefix"
}

prefix() {
    rm -rf "$scratch"
    mkdir -p "$scratch"
    cd "$scratch" || exit 1
    must cmake --install "$1" --prefix "$scratch/installed"
    move_prefix
}

other_prefix() {
    local build=$1
    shift
    mkdir -p "$scratch"
    cd "$scratch" || exit 1
    rm -rf installed
    must cmake -S "$source_dir" -B build "$@"
    must cmake --build build --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}"
    must cmake --install build --prefix "$scratch/installed"
    must cmake --install "$build" --prefix "$scratch/installed" --component runtime
    move_prefix
}

# Each component holds what it should, and no file leads back to the sources or the build.
files() {
    local build=$1 file
    enter files
    must cmake --install "$build" --prefix "$PWD/runtime" --component runtime
    must cmake --install "$build" --prefix "$PWD/development" --component development
    for file in bin/bsoil share/bulletsoil/scenes/excavator.toml share/bulletsoil/experiments/ding_wheel.toml; do
        [[ -f runtime/$file ]] || fail "runtime has no $file"
        [[ ! -e development/$file ]] || fail "development has $file"
    done
    [[ -n $(find runtime/share/doc -name LICENSE) ]] || fail "runtime has no licence"
    for file in bsoil/soil.h bsoil/version.h bsoil/render/renderer.h bsoil/bullet/soil_action.h bsoil/c/bulletsoil.h; do
        [[ -f development/include/$file ]] || fail "development has no include/$file"
    done
    [[ ! -e runtime/include ]] || fail "runtime has headers"
    for file in "$source_dir" "$build" "$scratch"; do
        ! grep -rlF -- "$file" runtime development || fail "these name $file"
    done
}

# All headers together, the C header from strict C99, and what a header declares is exported by a shared library, under the
# name of its precision.
headers() {
    use_prefix
    enter headers
    local header
    while IFS= read -r header; do
        case $header in */result.h | */geometry.h | */limits.h | */cxx20.h | */body.h | */precision.h | */mean_pressure.h | */momentum_flux.h) continue ;; esac # inline only
        grep -q 'visibility push(default)' "$header" || fail "$header: put visibility push(default) before its namespace"
        [[ $header != */bsoil/bullet/* ]] || grep -q 'inline BSOIL_BULLET_PRECISION {' "$header" ||
            fail "$header: its namespace is bsoil::bullet::inline BSOIL_BULLET_PRECISION, see bsoil/bullet/precision.h"
    done < <(find "$prefix/include" -name '*.h')
    include_all >all.cpp
    (($(wc -l <all.cpp) >= 10)) || fail "only these headers: $(cat all.cpp)"
    must_be_cpp all.cpp
    printf '#include <bsoil/c/bulletsoil.h>\nint nothing;\n' >one.c
    must cc -std=c99 -fsyntax-only -Wall -Wextra -Wpedantic -Werror "-I$prefix/include" one.c
}

# Every header can be included on its own. Sources include theirs first, so that builds file by file show it as well.
headers_alone() {
    use_prefix
    enter headers_alone
    local line
    while IFS= read -r line; do
        printf '%s\n' "$line" >one.cpp
        must_be_cpp one.cpp
    done < <(include_all)
}

include_all() {
    local header
    while IFS= read -r header; do
        printf '#include <%s>\n' "${header#"$prefix/include/"}"
    done < <(find "$prefix/include" -name '*.h' | sort)
}

must_be_cpp() {
    local flags
    flags=$(pkg-config --cflags bulletsoil-bullet bulletsoil-render) || fail "pkg-config"
    # shellcheck disable=SC2086
    must c++ -std=c++20 -fsyntax-only -Wall -Wextra -Werror $flags "$1"
}

# What is not built is not half installed.
unbuilt() {
    enter unbuilt
    must cmake -S "$source_dir" -B build -DBULLETSOIL_TESTS=OFF
    must_fail 'is not built, so nothing was installed; build everything first: cmake --build' \
        cmake --install build --prefix "$PWD/installed"
    [[ -z $(find installed -type f 2>/dev/null) ]] || fail "installed: $(find installed -type f)"
}

# A host that compiles for an older C++ reads one sentence, whatever it includes first.
old_standard() {
    use_prefix
    enter old_standard
    local flags header
    flags=$(pkg-config --cflags bulletsoil-bullet bulletsoil-render) || fail "pkg-config"
    while IFS= read -r header; do
        header=${header#"$prefix/include/"}
        case $header in bsoil/c/* | bsoil/limits.h | bsoil/version.h) continue ;; esac # any C++
        printf '#include <%s>\n' "$header" >one.cpp
        # shellcheck disable=SC2086
        must_fail 'BulletSoil needs C\+\+20: compile with -std=c\+\+20' c++ -std=c++17 -fsyntax-only $flags one.cpp
        (($(grep -c 'error:' log) == 2)) || fail "$header: more than the sentence and the end: $(cat log)"
    done < <(find "$prefix/include" -name '*.h')
}

# What shared libraries export: the project's own names, those of a bridge with its precision, nothing of what they use.
symbols() {
    use_prefix
    enter symbols
    local library bits
    for library in soil render bullet bullet_double; do
        # Weak ones are inline functions and templates.
        nm -DC --defined-only "$lib/libbulletsoil_$library.so" | sed -nE 's/^[0-9a-f]+ [TDBR] //p' >names || fail nm
        bits=32
        [[ $library != *double ]] || bits=64
        case $library in
            bullet*) grep -vE "^(bsoil::bullet::float$bits::|bulletsoil_)" names && fail "$library exports these" ;;
            *) grep -vE '^bsoil::' names && fail "$library exports these" ;;
        esac
        [[ -s names ]] || fail "$library exports nothing"
    done
}

write_host() {
    cp "$hosts"/* "$source_dir/demos/src/hosts/hello_soil.cpp" .
    cp "$source_dir/tests/scenes/sand_column.toml" column.toml
    sed 's/sand_column/column/' "$source_dir/tests/scenes/sand_column.json" >column.json
    page_file put_sand_under.c >put_sand_under.c
    cat column.toml - >no_data.toml <<<$'[[robot]]\nname = "r"\nfile = "data:not/there.urdf"'
}

cmake_host() {
    use_prefix
    unset LD_LIBRARY_PATH PKG_CONFIG_PATH
    enter cmake_host
    write_host
    must cmake -S . -B build "-DCMAKE_PREFIX_PATH=$prefix"
    must cmake --build build
    must ctest --test-dir build --output-on-failure --no-tests=error
    grep -qE 'no_data .*Skipped' log || fail "a scene without its data is not skipped: $(cat log)"
    grep -q 'as it should be' build/Testing/Temporary/LastTest.log || fail "hello_soil is silent"

    # A baseline that differs fails the test; the target writes the one that was there.
    cp column.json before.json
    sed -i 's/"checksum": "[0-9a-f]*"/"checksum": "0"/' column.json
    must_fail 'end.checksum: expected' ctest --test-dir build -R '^column$' --output-on-failure
    must cmake --build build --target column.update_baseline
    must cmp column.json before.json

    must_fail 'BULLETSOIL_SCALAR_BITS' cmake -S . -B build -DMIX_PRECISIONS=ON
}

# The README's own project, and mistakes in it.
readme_host() {
    use_prefix
    unset LD_LIBRARY_PATH PKG_CONFIG_PATH
    enter readme_host
    write_host
    page_file CMakeLists.txt >CMakeLists.txt
    must cmake -S . -B build "-DCMAKE_PREFIX_PATH=$prefix"
    must cmake --build build
    must ./build/digger
    must ctest --test-dir build --output-on-failure --no-tests=error

    # mistake SED_EXPRESSION TEXT: cmake refuses the changed project, which it knows: it asks the compiler nothing again.
    mistake() {
        page_file CMakeLists.txt | sed "$1" >CMakeLists.txt
        must_fail "$2" cmake -S . -B build
    }
    mistake 's/COMPONENTS bullet/COMPONENTS jelly/' 'jelly is not installed'
    mistake 's/BulletSoil 0.1/BulletSoil 0.99/' 'requested version "0.99"'
    mistake 's/BulletSoil 0.1/BulletSoil 1.0/' 'requested version "1.0"'
    mistake 's/SCENE column.toml/SCENE nothing.toml/' 'SCENE .*nothing.toml is not there'
    mistake 's/SCENE column.toml//' 'SCENE is missing'
    mistake 's/TIMEOUT 60/TIMEUP 60/' 'TIMEUP;60 is not understood'
    mistake 's/TIMEOUT 60/BACKEND abacus/' 'BACKEND is abacus'
    mistake 's/bullet command/bullet/' "component 'command'"
}

# The tutorial, from its first line to its last: every block but what programs print, commands in the order of the page.
tutorial() {
    use_prefix
    export PATH=$prefix/bin:$PATH CMAKE_PREFIX_PATH=$prefix
    enter tutorial
    local page=docs/tutorial.md blocks name mode=compare
    [[ ${1:-} == update ]] && mode=update # writes what programs print into the page
    blocks=$(grep -cE '^```[a-z]' "$source_dir/$page")
    ((blocks - $(grep -c '^```text' "$source_dir/$page") == $(grep -c '^<!-- tested as ' "$source_dir/$page"))) ||
        fail "$page has blocks of code that are not tested"
    while IFS= read -r name; do
        page_file "$name" "$page" >"$name"
    done < <(sed -nE 's/^<!-- tested as (.*) -->$/\1/p' "$source_dir/$page" | sort -u)
    for name in 1 2 3 4 5 6; do
        must sh -e "./$name.sh"
    done
    # 1962 N, and no deeper than its radius.
    ./hello_sand | tee hello.txt | awk '
        /lowest point/ { height = $(NF - 1) }
        /pushes/ { force = $(NF - 1) }
        END { exit !(height > 0.2 && height < 0.49 && force > 1900 && force < 2020) }' || fail "hello_sand: $(cat hello.txt)"
    for name in contact_sheet.png telemetry.csv summary.json final.snapshot; do
        [[ -s out/wheel/$name ]] || fail "bsoil run left no $name"
    done
    [[ ! -e 7.sh ]] || fail "commands that are not run"
    "$source_dir/tests/install/printed_blocks.sh" "$source_dir/$page" "$mode" || fail "$page says otherwise; write it
anew: tests/install/check_install.sh SOURCE SCRATCH tutorial update, once SCRATCH holds what \`prefix\` installs"
    ! ./wheel | grep -E '^(status|refused)' || fail "$page says that nothing is printed"
}

# The same targets from the sources, in a project that has no use for their tests. Configured only.
subdirectory() {
    enter subdirectory
    write_host
    {
        printf 'cmake_minimum_required(VERSION 3.25)\nproject(outer LANGUAGES C CXX)\n'
        printf 'add_subdirectory(%s bulletsoil)\n' "$source_dir"
        page_file CMakeLists.txt | grep -vE '^(cmake_minimum|project|find_package)'
    } >CMakeLists.txt
    must cmake -S . -B build
    must ctest --test-dir build -N
    grep -qE 'Total Tests: 1$' log || fail "more than the project's own test: $(cat log)"
}

pkg_config_host() {
    use_prefix
    enter pkg_config_host
    write_host
    page_file build.sh >build.sh
    local bullet
    for bullet in bullet bullet-float64; do
        sed -i "s/bulletsoil-bullet[-a-z0-9]*/bulletsoil-$bullet/" build.sh
        must sh -e build.sh
        must ./hello_soil
        # shellcheck disable=SC2046
        must cc -std=c99 -Wall -Wextra -Wpedantic -Werror -c put_sand_under.c $(pkg-config --cflags "bulletsoil-$bullet")
        # shellcheck disable=SC2046
        must c++ c_host.cpp put_sand_under.o -o c_host $(pkg-config --cflags --libs "bulletsoil-$bullet")
        must ./c_host
    done
    # shellcheck disable=SC2046
    must c++ -std=c++20 soil_host.cpp -o soil_host $(pkg-config --cflags --libs bulletsoil-render)
    must ./soil_host
    [[ $(pkg-config --modversion bulletsoil) == "$("$prefix/bin/bsoil" --version)" ]] || fail "two versions"
}

# A program of one precision is not built against the library of the other, whatever it does.
mixed_precision() {
    use_prefix
    enter mixed_precision
    write_host
    local flags
    flags=$(pkg-config --cflags --libs bulletsoil-bullet)
    # shellcheck disable=SC2086
    must_fail 'float library is linked.*link BulletSoil::bullet_double' \
        c++ -std=c++20 -DBT_USE_DOUBLE_PRECISION hello_soil.cpp -o hello $flags
    # shellcheck disable=SC2086
    must_fail 'undefined reference to .bsoil::bullet::float64::SoilAction::create' \
        c++ -std=c++20 -DBT_USE_DOUBLE_PRECISION hello_soil.cpp -o hello $flags -UBULLETSOIL_SCALAR_BITS
    flags=$(pkg-config --cflags --libs bulletsoil-bullet-float64)
    # shellcheck disable=SC2086
    must_fail 'double library is linked.*link BulletSoil::bullet ' \
        c++ -std=c++20 hello_soil.cpp -o hello $flags -UBT_USE_DOUBLE_PRECISION
    # shellcheck disable=SC2086
    must_fail 'undefined reference to .bsoil::bullet::float32::SoilAction::create' \
        c++ -std=c++20 hello_soil.cpp -o hello $flags -UBT_USE_DOUBLE_PRECISION -UBULLETSOIL_SCALAR_BITS
}

# The command finds its files beside itself, and kernels in itself.
installed_command() {
    use_prefix
    unset LD_LIBRARY_PATH
    enter installed_command
    local bsoil=$prefix/bin/bsoil scene=$source_dir/tests/scenes/sand_column.toml
    must "$bsoil" info
    must "$bsoil" check "$scene" --against "${scene%.toml}.json" --backend cpu
    if "$bsoil" info --backend gl >log 2>&1; then
        must "$bsoil" check "$scene" --against "${scene%.toml}.json" --backend gl --steps 60
    else
        printf 'no OpenGL: on the CPU only\n'
    fi
    must "$bsoil" run "$prefix/share/bulletsoil/scenes/column.toml" --steps 2 --no-pictures --out out
    # All experiments are found and none has data: 77, not 2.
    BULLETSOIL_DATA=$PWD "$bsoil" validate >log 2>&1
    [[ $? == 77 ]] || fail "bsoil validate: $(cat log)"
    grep -qF "SKIP $prefix/share/bulletsoil/experiments/ding_wheel.toml" log || fail "$(cat log)"
}

"$test_case" "$@"
