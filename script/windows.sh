# Sourced by script/windows after lib.sh: a Rust compiler and a linker for Windows. What they make runs in a Wine (script/wine.sh).

WINDOWS_TARGET=x86_64-pc-windows-gnu
WINDOWS_FOLDER=${CARGO_TARGET_DIR:-target}/windows
case $WINDOWS_FOLDER in /*) ;; *) WINDOWS_FOLDER=$PWD/$WINDOWS_FOLDER ;; esac
# What of this machine's folders is called in what is made: of several that match, the last holds. Cargo's and the person's are not named either.
WINDOWS_CARGO_HOME=${CARGO_HOME:-$HOME/.cargo}
WINDOWS_NAMES=("$PWD=/lumivox" "$WINDOWS_CARGO_HOME/registry/src=/crates" "$WINDOWS_FOLDER=/target" "$WINDOWS_FOLDER/toolchain/root=/rust")
WINDOWS_UNNAMED=("$PWD" "$WINDOWS_FOLDER" "$WINDOWS_CARGO_HOME" "$HOME")

# Debian packages that make up a private toolchain: a compiler that Debian keeps new enough in a release that it maintains,
# the sources of its library, which Debian builds for no Windows, and MinGW's compilers, those with C++ threads.
WINDOWS_RELEASE=bookworm
WINDOWS_PACKAGES="rustc-web rust-web-src g++-mingw-w64-x86-64-posix libz-mingw-w64"

# Libraries that every Windows 10 has, besides those whose names begin with api-ms-win-.
WINDOWS_LIBRARIES="advapi32.dll bcrypt.dll bcryptprimitives.dll combase.dll kernel32.dll msvcrt.dll ntdll.dll ole32.dll oleaut32.dll rpcrt4.dll setupapi.dll shell32.dll user32.dll userenv.dll ws2_32.dll"

# And those that every Windows 10 with a desktop has.
WINDOWS_DESKTOP="crypt32.dll dwmapi.dll gdi32.dll imm32.dll propsys.dll shlwapi.dll uiautomationcore.dll uxtheme.dll"

# URIs of mirrors of Debian's archive of security updates, one a line: what this system's own apt sources name, and what stands
# beside the mirror $1.
debian_security_mirrors() {
    # Single quotes on purpose: apt fills these in.
    # shellcheck disable=SC2016
    [ -n "${DEBIAN_MIRROR:-}" ] || apt-get indextargets --no-release-info --format '$(RELEASE) $(REPO_URI)' \
        'Target-Of: deb' 'Created-By: Packages' 'Component: main' </dev/null 2>/dev/null |
        awk '$1 ~ /-security$/ && $2 !~ /^(cdrom|copy):/ && !known[$2]++ { print $2 }'
    printf '%s\n' "${1%/}-security"
}

# Fetches what is not there.
need_windows_toolchain() {
    local folder=$WINDOWS_FOLDER/toolchain made_of
    made_of="$WINDOWS_RELEASE $WINDOWS_PACKAGES
$(declare -f fetch_windows_toolchain wrap_windows_toolchain build_windows_std with_windows_toolchain nameless | cksum)"
    if [ "$(cat "$folder/made-of" 2>/dev/null)" != "$made_of" ] || ! rustc_is_new_enough "$folder/bin/rustc"; then
        [ "$(uname -s) $(uname -m)" = "Linux x86_64" ] && command -v apt-get >/dev/null 2>&1 &&
            command -v dpkg-deb >/dev/null 2>&1 && [ -e "$DEBIAN_KEYRING" ] ||
            die "The compilers for Windows are fetched from Debian: that takes Linux (x86_64) with apt-get, dpkg-deb and 'debian-archive-keyring'."
        fetch_windows_toolchain "$folder"
        rustc_is_new_enough "$folder/bin/rustc" || die "Debian's compiler for Windows is older than Rust $RUST_VERSION, or does not run here."
        build_windows_std "$folder"
        printf '%s\n' "$made_of" >"$folder/made-of"
    fi
}

# Unpacks Debian's compilers into the folder $1, from the first mirrors that have them.
fetch_windows_toolchain() {
    local mirrors mirror security
    mirrors=$(debian_mirrors)
    [ -n "$mirrors" ] || die "apt's sources name no mirror of Debian to fetch compilers for Windows from. Name one, as they would:
    DEBIAN_MIRROR=URI $0"
    say "Fetching compilers for Windows from Debian into $1 (300 MB, nothing is installed)"
    for mirror in $mirrors; do
        for security in $(debian_security_mirrors "$mirror"); do
            # Unquoted on purpose: a list of words.
            # shellcheck disable=SC2086
            if fetch_debian "$1" "$mirror $WINDOWS_RELEASE
$security $WINDOWS_RELEASE-security" $WINDOWS_PACKAGES && wrap_windows_toolchain "$1"; then
                return 0
            fi
        done
    done
    die "The compilers could not be fetched from $mirror (see $1/log). Name another mirror of Debian, with one of the same name and '-security' beside it:
    DEBIAN_MIRROR=URI $0"
}

# Has the compilers in the folder $1 run with their own loader and libraries, so that the system's age does not matter, and
# puts those that others call into $1/bin.
wrap_windows_toolchain() (
    cd "$1" && mkdir bin || exit 1
    triple=x86_64-w64-mingw32
    # The loader tells no program by which name it was called, and these find each other by their own.
    cat >wrapper <<'RUN' || exit 1
#!/bin/sh
program=$(readlink -f "$0")
root=${program%/usr/*}
exec "$root/lib/x86_64-linux-gnu/ld-linux-x86-64.so.2" --argv0 "$program" \
    --library-path "$root/usr/lib/x86_64-linux-gnu:$root/lib/x86_64-linux-gnu" "$program.elf" "$@"
RUN
    chmod +x wrapper || exit 1
    for program in root/usr/bin/$triple-* root/usr/$triple/bin/* root/usr/lib/gcc/$triple/*-posix/*; do
        [ -f "$program" ] && [ ! -L "$program" ] && [ -x "$program" ] || continue
        case $(head -c 4 "$program" | tr -d '\0') in *ELF) ;; *) continue ;; esac
        case $program in *.so | *.so.*) continue ;; esac
        mv "$program" "$program.elf" && cp wrapper "$program" || exit 1
    done
    rm wrapper
    for tool in gcc g++ c++ cpp gcc-ar gcc-nm gcc-ranlib ar as ld nm objcopy objdump ranlib strip dlltool windres; do
        for program in "root/usr/bin/$triple-$tool-posix" "root/usr/bin/$triple-$tool"; do
            [ ! -e "$program" ] || { ln -s "../$program" "bin/$triple-$tool" && break; } || exit 1
        done
    done
    # Only the static ones of MinGW's own libraries are left: what is made runs where nothing but Windows is.
    rm root/usr/$triple/lib/lib{,win}pthread.dll.a || exit 1
    for libraries in root/usr/lib/gcc/$triple/*-posix; do
        rm "$libraries/libstdc++.dll.a" && echo 'INPUT(-lgcc_eh)' >"$libraries/libgcc_s.a" || exit 1
    done
    cat >bin/rustc <<'RUN' || exit 1
#!/bin/sh
root=$(cd "$(dirname "$0")/.." && pwd)/root
exec "$root/lib/x86_64-linux-gnu/ld-linux-x86-64.so.2" --argv0 rustc \
    --library-path "$root/usr/lib/x86_64-linux-gnu:$root/lib/x86_64-linux-gnu" "$root/usr/bin/rustc" --sysroot "$root/usr" "$@"
RUN
    chmod +x bin/rustc
)

# Makes Rust's library for Windows of its sources, with what tests need, and puts it where the compiler in the folder $1 looks for it: from then on it
# is a compiler like any other.
build_windows_std() {
    say "Making Rust's library for Windows"
    local folder=$1 crate=$1/std library=$1/root/usr/lib/rustlib/$WINDOWS_TARGET/lib
    rm -rf "$crate" "$library"
    mkdir -p "$crate/src" "$library"
    printf '[package]\nname = "empty"\nversion = "0.1.0"\nedition = "2024"\n[workspace]\n' >"$crate/Cargo.toml"
    echo 'fn main() {}' >"$crate/src/main.rs"
    # Nothing but this is unstable: a library for a system that the compiler has none for.
    (cd "$crate" && RUSTC_BOOTSTRAP=1 with_windows_toolchain "${CARGO:-cargo}" build --release --quiet --target "$WINDOWS_TARGET" --target-dir target \
        -Zbuild-std=std,panic_unwind,test >"$folder/log" 2>&1 </dev/null) ||
        die "Rust's library for Windows could not be made (see $folder/log)."
    cp "$crate/target/$WINDOWS_TARGET"/release/deps/*.rlib "$library/"
    # Nobody needs it any more, nor Debian's compiler for Linux: half of it all.
    (cd "$folder/root/usr" && rm -rf "$crate" src share/{locale,man} lib/gcc/x86_64-linux-gnu)
}

# Whether the system's own compiler has a library for Windows: enough to check types, not to link.
system_compiles_windows() {
    local folder
    folder=$("${RUSTC:-rustc}" --print target-libdir --target "$WINDOWS_TARGET" </dev/null 2>/dev/null) || return 1
    [ -n "$(find "$folder" -name 'libcore-*.rlib' 2>/dev/null)" ]
}

# Runs cargo with these compilers, into a folder of their own: what they make serves nobody else.
windows_cargo() (
    export CARGO_TARGET_DIR=$WINDOWS_FOLDER/cargo CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=x86_64-w64-mingw32-gcc
    with_windows_toolchain "${CARGO:-cargo}" "$@"
)

# C compilers are told of names through a variable in which a space parts words.
with_windows_toolchain() (
    c=
    for names in "${WINDOWS_NAMES[@]}"; do
        case $names in *' '*) ;; *) c="$c -ffile-prefix-map=$names" ;; esac
    done
    rust=$(nameless "${WINDOWS_NAMES[@]}")
    export CARGO_ENCODED_RUSTFLAGS=$rust
    export CFLAGS_x86_64_pc_windows_gnu="${CFLAGS_x86_64_pc_windows_gnu:-}$c" CXXFLAGS_x86_64_pc_windows_gnu="${CXXFLAGS_x86_64_pc_windows_gnu:-}$c"
    RUSTC=$WINDOWS_FOLDER/toolchain/bin/rustc PATH=$WINDOWS_FOLDER/toolchain/bin:$PATH "$@"
)

# Sets MATURIN, which makes wheels, of the version that those for Linux are made by.
need_maturin() {
    local folder=$WINDOWS_FOLDER/maturin wanted
    wanted=$(grep '^maturin==' python/requirements-test.txt)
    MATURIN=$folder/bin/maturin
    [ "$("$MATURIN" --version 2>/dev/null </dev/null)" != "maturin ${wanted#*==}" ] || return 0
    python3 -c 'import ensurepip, venv' >/dev/null 2>&1 </dev/null || install_packages python3 python3-venv
    rm -rf "$folder"
    python3 -m venv "$folder"
    "$folder/bin/python" -m pip install --quiet --disable-pip-version-check "$wanted" </dev/null
}

# Fails where the program or library $1 needs one that Windows has not; others that it may need follow.
needs_only_windows() {
    local needed library others=
    needed=$("$WINDOWS_FOLDER/toolchain/bin/x86_64-w64-mingw32-objdump" -p "$1" | sed -n 's/^[[:space:]]*DLL Name: //p' | tr '[:upper:]' '[:lower:]')
    [ -n "$needed" ] || die "$1 is no program or library for Windows."
    for library in $needed; do
        case $library in
            api-ms-win-*.dll | ext-ms-win-*.dll) ;;
            *) case " $WINDOWS_LIBRARIES ${2:-} " in *" $library "*) ;; *) others="$others $library" ;; esac ;;
        esac
    done
    [ -z "$others" ] || die "$1 needs what not every Windows has:$others"
}

# Fails where the program or library $1 names a folder of the machine that it was made on.
needs_no_folder() {
    local folder found
    case ${WINDOWS_NAMES[*]} in *' '*) return 0 ;; esac
    for folder in "${WINDOWS_UNNAMED[@]}"; do
        [ "${folder%/}" ] || continue
        found=$(LC_ALL=C grep -aoF -m 1 "${folder%/}/" "$1" | head -n 1) || :
        [ -z "$found" ] || die "$1 names where it was made: $(LC_ALL=C grep -ao -m 1 "${folder%/}/[[:graph:]]*" "$1" | head -n 1)"
    done
}
