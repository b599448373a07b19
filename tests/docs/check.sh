# What the checks of the sources and pages share: they run in the project's root, print each fault and go on; at the end `exit "$failed"`.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 1
failed=0
fail() {
    printf '%s\n' "$*"
    failed=1
}
