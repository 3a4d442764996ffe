# Sourced by script/godot and script/test after lib.sh: a Godot that runs the addon.

GODOT_MINIMUM=4.5

# Debian packages that make up a private Godot where the system has none: the engine, and the drivers that go with its
# C library (on a machine without a GPU, Vulkan in software), and Monado, which simulates the headset of the tests.
GODOT_PACKAGES="godot mesa-vulkan-drivers libvulkan1 monado-service libopenxr1-monado"

# Whether the program $1 is a Godot of at least GODOT_MINIMUM.
godot_is_new_enough() {
    local version oldest
    version=$("$1" --version </dev/null 2>/dev/null | tail -n 1) || return 1
    version=$(printf '%s' "$version" | cut -d. -f1,2)
    case $version in [0-9]*.[0-9]*) ;; *) return 1 ;; esac
    oldest=$(printf '%s\n%s\n' "$GODOT_MINIMUM" "$version" | sort -t. -k1,1n -k2,2n | head -n 1)
    [ "$oldest" = "$GODOT_MINIMUM" ]
}

# Sets and exports GODOT: the one that is asked for, one from PATH, or a private one from Debian, which comes with MONADO.
need_godot() {
    local candidate
    if [ -n "${GODOT:-}" ]; then
        godot_is_new_enough "$GODOT" || die "GODOT=$GODOT is no Godot $GODOT_MINIMUM or newer."
        export GODOT
        return 0
    fi
    for candidate in godot godot4 godot-4; do
        if command -v "$candidate" >/dev/null 2>&1 && godot_is_new_enough "$candidate"; then
            GODOT=$(command -v "$candidate")
            export GODOT
            return 0
        fi
    done
    local folder=${CARGO_TARGET_DIR:-target}/godot-engine
    case $folder in /*) ;; *) folder=$PWD/$folder ;; esac
    GODOT=$folder/godot
    MONADO=${MONADO:-$folder/monado-service}
    export GODOT MONADO
    [ -x "$GODOT" ] && [ -x "$MONADO" ] && godot_is_new_enough "$GODOT" && return 0
    local help="Install Godot $GODOT_MINIMUM or newer from https://godotengine.org/download and put it on the PATH as 'godot', or name it:
    GODOT=/path/to/godot $0"
    [ "$(uname -s) $(uname -m)" = "Linux x86_64" ] && command -v apt-get >/dev/null 2>&1 &&
        command -v dpkg-deb >/dev/null 2>&1 || die "There is no Godot $GODOT_MINIMUM on the PATH. $help"
    [ -e "$DEBIAN_KEYRING" ] || die "There is no Godot $GODOT_MINIMUM on the PATH. $help
One can be fetched from Debian, too, once 'debian-archive-keyring' is installed."
    local mirrors mirror
    mirrors=$(debian_mirrors)
    [ -n "$mirrors" ] || die "There is no Godot $GODOT_MINIMUM on the PATH, and apt's sources name no mirror of Debian to fetch one from. $help
or name a mirror, as apt's sources would:
    DEBIAN_MIRROR=URI $0"
    say "No Godot $GODOT_MINIMUM on the PATH: fetching one from Debian into $folder (270 MB, nothing is installed)"
    local fetched=
    for mirror in $mirrors; do
        if fetch_godot "$folder" "$mirror"; then
            fetched=1
            break
        fi
    done
    [ -n "$fetched" ] || die "Godot could not be fetched from $mirror (see $folder/log). $help
or name another mirror of Debian:
    DEBIAN_MIRROR=URI $0"
    godot_is_new_enough "$GODOT" || die "The Godot from Debian does not run here (see $folder/log). $help"
}

# Unpacks Debian's Godot from the mirror $2 into the folder $1.
fetch_godot() (
    # Nothing is left to `set -e`, which nothing heeds where the caller looks at the outcome.
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    fetch_debian "$1" "$2 forky" $GODOT_PACKAGES && cd "$1" || exit 1
    # Its own loader and libraries first, so that the system's age does not matter; the system's come last, for its
    # GPU's driver.
    cat >run <<'RUN' || exit 1
#!/bin/sh
# Runs the program that this is linked as.
here=$(cd "$(dirname "$0")" && pwd)
root=$here/root
libraries=$root/usr/lib/x86_64-linux-gnu
gpu=
for device in /dev/dri/renderD* /dev/nvidia0; do [ ! -e "$device" ] || gpu=1; done
[ -n "$gpu$VK_DRIVER_FILES" ] || export VK_DRIVER_FILES="$root/usr/share/vulkan/icd.d/lvp_icd.json"
[ -n "$XDG_RUNTIME_DIR" ] || export NODEVICE_SELECT=1
exec "$root/usr/lib64/ld-linux-x86-64.so.2" --library-path \
    "$libraries:$libraries/pulseaudio:$libraries/blas:$libraries/lapack:$root/usr/lib:/usr/lib/x86_64-linux-gnu:/usr/local/lib:/usr/lib64" \
    "$root/usr/bin/$(basename "$0")" "$@"
RUN
    chmod +x run && ln -s run godot && ln -s run monado-service || exit 1
    runtime=root/usr/lib/x86_64-linux-gnu/libopenxr_monado.so
    printf '{"file_format_version": "1.0.0", "runtime": {"name": "Monado", "library_path": "%s"}}\n' \
        "$PWD/$runtime" >openxr_monado.json
)

# Builds the extension and the program that decodes for it, and puts both where the project $1 looks for it.
build_addon() {
    "${CARGO:-cargo}" build ${CI:+--locked} --release --quiet --package lumivox-godot --package lumivox-import </dev/null
    local built=${CARGO_TARGET_DIR:-target}/release bin=$1/addons/lumivox/bin
    case "$(uname -s)" in
        Darwin) bin=$bin/macos && mkdir -p "$bin" && cp "$built/liblumivox_godot.dylib" "$built/lumivox-codecs" "$bin/" ;;
        Linux)
            bin=$bin/linux.$(uname -m | sed s/aarch64/arm64/) && mkdir -p "$bin" && cp "$built/liblumivox_godot.so" "$built/lumivox-codecs" "$bin/"
            # Line tables are nine tenths of them.
            ! command -v strip >/dev/null 2>&1 || strip --strip-debug "$bin/liblumivox_godot.so" "$bin/lumivox-codecs"
            ;;
        *) bin=$bin/windows.x86_64 && mkdir -p "$bin" && cp "$built/lumivox_godot.dll" "$built/lumivox-codecs.exe" "$bin/" ;;
    esac
    # Without this list the first import of a fresh project does not know the classes that its scenes need.
    mkdir -p "$1/.godot"
    echo "res://addons/lumivox/lumivox.gdextension" >"$1/.godot/extension_list.cfg"
}
