# Shared by script/run and script/test: what a machine needs before it can build and render.
# Runs under bash 3.2 too, which macOS has.

say() { printf '==> %s\n' "$*"; }
die() { printf 'error: %s\n' "$*" >&2; exit 1; }

RUST_VERSION=1.95

# Leaves a usable `cargo` in PATH, or says how to get one.
need_rust() {
    if ! command -v cargo >/dev/null 2>&1 && [ -x "$HOME/.cargo/bin/cargo" ]; then
        PATH="$HOME/.cargo/bin:$PATH"
        export PATH
    fi
    local install="curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y --default-toolchain $RUST_VERSION.0"
    command -v cargo >/dev/null 2>&1 || die "Rust is not installed. Install it with
    $install
and run this script again in a new shell."
    local version oldest
    version=$(cargo --version </dev/null | cut -d' ' -f2) || die "'cargo --version' fails; repair the Rust toolchain."
    oldest=$(printf '%s\n%s\n' "$RUST_VERSION" "${version%%-*}" | sort -t. -k1,1n -k2,2n | head -n 1)
    [ "$oldest" = "$RUST_VERSION" ] || die "Rust $version is too old, Lumivox needs $RUST_VERSION. Update it with
    rustup update
or, without rustup, with
    $install"
}

# The project's chores, by the program that does some already where there is one.
xtask() {
    if [ -n "${LUMIVOX_XTASK:-}" ]; then
        "$LUMIVOX_XTASK" "$@" </dev/null
    else
        "${CARGO:-cargo}" run --release --quiet --package xtask -- "$@" </dev/null
    fi
}

# Flags of the compiler as Cargo reads several: those that are asked for, and such by which what is made names no folder of
# whoever makes it. Each of FOLDER=NAME says what one is called; of several that match, the last holds.
nameless() {
    local unit flags names
    unit=$(printf '\037')
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    flags=${CARGO_ENCODED_RUSTFLAGS-$(set -f && set -- ${RUSTFLAGS:-} && IFS=$unit && printf '%s' "$*")}
    for names in "$@"; do
        flags=$flags${flags:+$unit}--remap-path-prefix=$names
    done
    printf '%s' "$flags"
}

# Makes what the notebook's widget sends to browsers, of the npm package that is made in the folder $1, and puts it into the Python package.
make_notebooks_page() {
    local web=python/lumivox/web
    rm -rf "$web"
    script/js --out "$1" && mkdir "$web" && cp "$1"/lumivox.js "$1"/lumivox_wasm.js "$1"/lumivox_wasm_bg.wasm "$web/"
}

# Whether the loader finds the library $1.
has_library() {
    # Not grep -q: it stops reading, and pipefail would take ldconfig's broken pipe for an answer.
    { ldconfig -p || /sbin/ldconfig -p; } 2>/dev/null | grep -F "$1" >/dev/null
}

has_vulkan_loader() { has_library libvulkan.so.1; }

# Whether a Vulkan driver whose manifest matches the pattern $1 is installed.
has_vulkan_driver() {
    [ -z "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] || return 0
    local folder manifest
    for folder in /usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d /etc/vulkan/icd.d "$HOME/.local/share/vulkan/icd.d"; do
        for manifest in "$folder"/$1; do
            [ ! -e "$manifest" ] || return 0
        done
    done
    return 1
}

has_gpu() {
    local device
    for device in /dev/dri/renderD* /dev/nvidia0 /dev/dxg; do
        [ ! -e "$device" ] || return 0
    done
    return 1
}

# Fills MISSING (Debian packages) and REASONS with what this Linux lacks.
find_missing() {
    MISSING=
    REASONS=
    lack() {
        MISSING="$MISSING $1"
        REASONS="$REASONS
    $1: $2"
    }
    if ! command -v cc >/dev/null 2>&1 || ! command -v c++ >/dev/null 2>&1; then
        lack build-essential "a linker, and a C++ compiler for the JPEG decoders"
    fi
    command -v cmake >/dev/null 2>&1 || lack cmake "builds the JPEG-LS decoder"
    has_vulkan_loader || lack libvulkan1 "the Vulkan loader"
    if has_gpu; then
        has_vulkan_driver '*.json' || lack mesa-vulkan-drivers "Vulkan drivers, in hardware (AMD, Intel) and in software"
    else
        has_vulkan_driver 'lvp_icd*.json' || lack mesa-vulkan-drivers "Vulkan in software, as this machine shows no GPU"
    fi
    # Cargo downloads over HTTPS.
    [ -e /etc/ssl/certs/ca-certificates.crt ] || [ ! -e /etc/debian_version ] || lack ca-certificates "downloads over HTTPS"
}

# Installs Debian packages; asks nothing, and says what to do where it lacks the rights.
install_packages() {
    local root=
    if ! command -v apt-get >/dev/null 2>&1; then
        die "Install these, or what your system calls them, and run this script again: $*"
    elif [ "$(id -u)" -eq 0 ]; then
        root=env
    elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null </dev/null; then
        root="sudo -n env"
    else
        die "Installing them needs root. Run
    sudo apt-get update && sudo apt-get install -y --no-install-recommends $*
and then this script again."
    fi
    say "Installing $*"
    local log
    log=$(mktemp)
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    if ! {
        $root DEBIAN_FRONTEND=noninteractive apt-get update -q &&
            $root DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@"
    } >"$log" 2>&1 </dev/null; then
        tail -n 20 "$log" >&2
        rm -f "$log"
        die "apt-get could not install: $*"
    fi
    rm -f "$log"
}

# Installs what is missing; asks nothing, and says what to do where it lacks the rights.
need_packages() {
    case "$(uname -s)" in
        Linux) ;;
        Darwin)
            xcode-select -p >/dev/null 2>&1 || die "The command line tools are missing. Install them with
    xcode-select --install"
            command -v cmake >/dev/null 2>&1 || die "cmake is missing (it builds the JPEG-LS decoder). Install it with
    brew install cmake"
            return 0
            ;;
        *) return 0 ;;
    esac
    find_missing
    [ -n "$MISSING" ] || return 0
    say "This machine lacks:$REASONS"
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    install_packages $MISSING
    find_missing
    [ -z "$MISSING" ] || die "Still missing after the installation:$REASONS"
}

# A display that nobody sees, where there is none.
need_xvfb() {
    command -v Xvfb >/dev/null 2>&1 && command -v xvfb-run >/dev/null 2>&1 && return 0
    install_packages xvfb xauth
}

# What a program with a window loads while it starts: it is not linked to any of that.
need_x11() {
    [ "$(uname -s)" = Linux ] || return 0
    local library package missing=
    while read -r library package; do
        has_library "$library" || missing="$missing $package"
    done <<'TEXT'
libX11.so.6 libx11-6
libX11-xcb.so.1 libx11-xcb1
libXcursor.so.1 libxcursor1
libXi.so.6 libxi6
libxkbcommon.so.0 libxkbcommon0
libxkbcommon-x11.so.0 libxkbcommon-x11-0
TEXT
    [ -n "$missing" ] || return 0
    say "This machine lacks what windows need:$missing"
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    install_packages $missing
}

# What vouches for what is fetched, from whatever mirror.
DEBIAN_KEYRING=/usr/share/keyrings/debian-archive-keyring.gpg

# URIs of mirrors of Debian's archive, one a line: DEBIAN_MIRROR, or what this system's own apt sources name, if it is a
# Debian by the file $1. Others may be among them; what is fetched must be signed by Debian.
debian_mirrors() {
    if [ -n "${DEBIAN_MIRROR:-}" ]; then
        printf '%s\n' "$DEBIAN_MIRROR"
        return 0
    fi
    # Others' archives, Ubuntu's too, hold other packages.
    grep -qx 'ID="\{0,1\}debian"\{0,1\}' "${1:-/etc/os-release}" 2>/dev/null || return 0
    # Single quotes on purpose: apt fills these in. The security archive and the additions to a release have no others.
    # shellcheck disable=SC2016
    apt-get indextargets --no-release-info --format '$(RELEASE) $(REPO_URI)' \
        'Target-Of: deb' 'Created-By: Packages' 'Component: main' </dev/null 2>/dev/null |
        awk '$1 !~ /[-\/]/ && $2 !~ /^(cdrom|copy):/ && !known[$2]++ { print $2 }'
}

# Unpacks packages of Debian's, $3 and the following, and all that they need, the C library too, into $1/root, which nothing
# else looks at. $2 says where from: a mirror and a release of Debian's on each line. Proxies and passwords are those of the
# system's apt.
fetch_debian() (
    folder=$1 sources=$2
    shift 2
    # Nothing is left to `set -e`, which nothing heeds where the caller looks at the outcome.
    rm -rf "$folder" && mkdir -p "$folder/lists/partial" "$folder/archives/partial" "$folder/root" && cd "$folder" || exit 1
    : >status || exit 1
    while read -r mirror release; do
        echo "deb [signed-by=$DEBIAN_KEYRING] $mirror $release main"
    done <<<"$sources" >sources.list || exit 1
    cat >apt.conf <<CONF || exit 1
Dir::Etc::sourcelist "$folder/sources.list";
Dir::Etc::sourceparts "/dev/null";
Dir::State::lists "$folder/lists";
Dir::State::status "$folder/status";
Dir::Cache "$folder";
Acquire::Check-Valid-Until "false";
Acquire::Retries "3";
Acquire::Languages "none";
APT::Install-Recommends "false";
APT::Sandbox::User "root";
Debug::NoLocking "true";
CONF
    {
        apt-get -c "$folder/apt.conf" update -q &&
            apt-get -c "$folder/apt.conf" install -y -q --download-only "$@" &&
            for package in archives/*.deb; do dpkg-deb -x "$package" root || exit 1; done
    } >log 2>&1 </dev/null || exit 1
    rm -rf archives lists ./*pkgcache.bin
)

# Without a desktop, a layer of Mesa prints an error about XDG_RUNTIME_DIR for every program that asks for a GPU.
[ -n "${XDG_RUNTIME_DIR:-}" ] || export NODEVICE_SELECT=1
