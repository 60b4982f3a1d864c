# What scripts/run and scripts/test share: stages that name themselves, and a machine that has all it needs.
# To be sourced. It fetches nothing when nothing is missing.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
command_name=scripts/$(basename "$0")
venv=$root/.venv
requirements=$root/scripts/requirements.txt
test_requirements=$root/scripts/requirements-test.txt
oldest_gfortran=12

# What has to be on the machine: a probe, and the Debian package that supplies it.
tools=(gfortran:gfortran gcc:gcc cmake:cmake ninja:ninja-build pkg-config:pkg-config git:git)
# What the tests of studies start: a batch system, and two other ways to run shards.
launchers=(munge slurmctld slurmd slurm-client openmpi-bin parallel)
libraries=(libc6-dev liblapack-dev libblas-dev libhdf5-dev ca-certificates)

current_stage='start'

# Announces a stage; a command that fails from here on is reported under its name.
stage() {
    current_stage=$1
    printf '==> %s\n' "$1"
}

die() {
    printf '%s: error: %s\n' "$command_name" "$1" >&2
    trap - ERR
    exit 1
}

report_failure() {
    local status=$?
    # A subshell reports to its parent, which speaks for both.
    [ "$BASH_SUBSHELL" -eq 0 ] && printf '%s: failed in stage: %s\n' "$command_name" "$current_stage" >&2
    exit "$status"
}

set -E
trap report_failure ERR

# Runs a talkative command and shows what it said only when it fails.
quietly() {
    local log status=0
    log=$(mktemp)
    "$@" >"$log" 2>&1 </dev/null || status=$?
    [ "$status" -eq 0 ] || tail -n 40 "$log" >&2
    rm -f "$log"
    return "$status"
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    else
        sudo "$@"
    fi
}

have() {
    command -v "$1" >/dev/null 2>&1
}

package_installed() {
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

# apt_install PACKAGE...: as root or with sudo; without either, says what to ask for.
apt_install() {
    have apt-get || die "missing: $* (Debian's names; there is no apt-get here, please install them)"
    if [ "$(id -u)" -ne 0 ] && ! have sudo; then
        die "missing packages, and neither root nor sudo to install them: apt-get install $*"
    fi
    printf 'installing %s\n' "$*"
    # A stale or foreign source may fail to update while all we need can still be had: installing decides.
    quietly as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 update ||
        printf '%s: warning: apt-get update failed\n' "$command_name" >&2
    quietly as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 \
        install -y --no-install-recommends "$@"
}

gfortran_major() {
    "$1" -dumpversion 2>/dev/null | cut -d. -f1
}

# A distribution whose gfortran is too old may carry a newer one beside it.
choose_compiler() {
    [ -z "${FC:-}" ] || return 0
    local major
    major=$(gfortran_major gfortran)
    if [ "$major" -lt "$oldest_gfortran" ]; then
        have "gfortran-$oldest_gfortran" || apt_install "gfortran-$oldest_gfortran"
        export FC=gfortran-$oldest_gfortran
    fi
}

setup_toolchain() {
    stage 'toolchain: compiler, CMake, LAPACK, HDF5, Python'
    local missing=() entry package
    for entry in "${tools[@]}"; do
        have "${entry%%:*}" || missing+=("${entry#*:}")
    done
    # Elsewhere than on Debian's kin, CMake says which library it cannot find.
    if have dpkg-query; then
        for package in "${libraries[@]}"; do
            package_installed "$package" || missing+=("$package")
        done
    fi
    can_make_venv python3 || can_make_venv /usr/bin/python3 || venv_is_sound ||
        missing+=(python3 python3-venv)
    [ ${#missing[@]} -eq 0 ] || apt_install "${missing[@]}"
    choose_compiler
}

# Elsewhere than on Debian's kin the tests say which of them they lack.
setup_launchers() {
    stage 'launchers: Slurm, Open MPI, GNU parallel'
    local missing=() package
    if have dpkg-query && have apt-get; then
        for package in "${launchers[@]}"; do
            package_installed "$package" || missing+=("$package")
        done
        [ ${#missing[@]} -eq 0 ] || apt_install "${missing[@]}"
    fi
}

# What only the tests need: a browser for pages, a renderer without a display for VTK, a critic of man pages,
# the tools of Debian packages.
setup_test_tools() {
    stage 'tools of the tests: VTK, a browser'
    local missing=() package
    if have dpkg-query; then
        for package in libegl1 libegl-mesa0 libgl1-mesa-dri mandoc dpkg-dev valgrind; do
            package_installed "$package" || missing+=("$package")
        done
    fi
    if [ -z "$(find_browser)" ]; then
        if have apt-get; then
            missing+=(chromium)
        else
            printf '%s: warning: no browser: a test is skipped\n' "$command_name" >&2
        fi
    fi
    [ ${#missing[@]} -eq 0 ] || apt_install "${missing[@]}"
    if [ "$(cat "$venv/stamp-test" 2>/dev/null)" != "$(sha256sum <"$test_requirements")" ]; then
        quietly "$venv/bin/python" -m pip --disable-pip-version-check install -r "$test_requirements"
        sha256sum <"$test_requirements" >"$venv/stamp-test"
    fi
    GENTBEAM_BROWSER=$(find_browser)
    export GENTBEAM_BROWSER
}

find_browser() {
    local name
    for name in chromium chromium-browser google-chrome; do
        command -v "$name" 2>/dev/null && return 0
    done
    return 0
}

# The stamp ties the environment to the requirements it was made from.
venv_stamp() {
    sha256sum <"$requirements"
}

venv_is_sound() {
    [ -x "$venv/bin/python" ] && [ "$(cat "$venv/stamp" 2>/dev/null)" = "$(venv_stamp)" ] &&
        "$venv/bin/python" -c 'import h5py, matplotlib, numpy, pytest, fprettify' >/dev/null 2>&1
}

can_make_venv() {
    "$1" -c 'import ensurepip, venv' >/dev/null 2>&1
}

make_venv() {
    rm -rf "$venv"
    quietly "$1" -m venv "$venv" &&
        quietly "$venv/bin/python" -m pip --disable-pip-version-check install -r "$requirements" &&
        venv_stamp >"$venv/stamp" && venv_is_sound
}

setup_python() {
    stage 'Python environment .venv'
    ! venv_is_sound || return 0
    if can_make_venv python3; then
        printf 'making it with %s\n' "$(command -v python3)"
        ! make_venv python3 || return 0
        printf '%s: warning: that python3 does not do, trying /usr/bin/python3\n' "$command_name" >&2
    fi
    can_make_venv /usr/bin/python3 || apt_install python3 python3-venv
    make_venv /usr/bin/python3
}

# build PRESET [OPTION...]: configures and builds it; options go to cmake --build.
build() {
    stage "configure (preset $1)"
    (cd "$root" && quietly cmake --preset "$1" -DPython3_EXECUTABLE="$venv/bin/python")
    stage "build (preset $1)"
    (cd "$root" && cmake --build --preset "$@")
}

# Some tests run scenes that fail in a program that traps floating-point errors too.
build_debug_program() {
    build debug --target gentbeam
    export GENTBEAM_DEBUG="$root/build/debug/gentbeam"
}
