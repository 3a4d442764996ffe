# Sourced after lib.sh: Orthanc, an archive of a hospital as the Studio talks to, for tests.

ORTHANC_PACKAGES="orthanc orthanc-dicomweb"

# Sets ORTHANC, a program with the plugin of DICOMweb beside it in the folder ORTHANC_PLUGINS: the one that is named, the
# system's, or one from Debian, private to this project. The system's package would begin to serve on every machine's ports.
need_orthanc() {
    export ORTHANC ORTHANC_PLUGINS
    [ -z "${ORTHANC:-}" ] || { ORTHANC_PLUGINS=${ORTHANC_PLUGINS:-/usr/share/orthanc/plugins}; return 0; }
    ORTHANC=$(command -v Orthanc) && ORTHANC_PLUGINS=/usr/share/orthanc/plugins &&
        [ -e "$ORTHANC_PLUGINS/libOrthancDicomWeb.so" ] && return 0
    local folder=${CARGO_TARGET_DIR:-target}/orthanc mirror fetched=
    case $folder in /*) ;; *) folder=$PWD/$folder ;; esac
    ORTHANC=$folder/orthanc ORTHANC_PLUGINS=$folder/root/usr/share/orthanc/plugins
    [ ! -x "$ORTHANC" ] || return 0
    local help="Install Orthanc with its plugin for DICOMweb, or name one:
    ORTHANC=PROGRAM ORTHANC_PLUGINS=FOLDER $0"
    [ "$(uname -s) $(uname -m)" = "Linux x86_64" ] && command -v apt-get >/dev/null 2>&1 &&
        command -v dpkg-deb >/dev/null 2>&1 && [ -e "$DEBIAN_KEYRING" ] || die "There is no Orthanc. $help"
    say "Fetching Orthanc from Debian into $folder (nothing is installed)"
    for mirror in $(debian_mirrors); do
        if fetch_orthanc "$folder" "$mirror"; then
            fetched=1
            break
        fi
    done
    [ -n "$fetched" ] || die "Orthanc could not be fetched (see $folder/log). $help"
}

# Unpacks it from the mirror $2 into the folder $1.
fetch_orthanc() (
    # Nothing is left to `set -e`, which nothing heeds where the caller looks at the outcome.
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    fetch_debian "$1" "$2 forky" $ORTHANC_PACKAGES && cd "$1" || exit 1
    # With its own loader and libraries, so that the system's age does not matter.
    cat >orthanc.new <<'RUN' || exit 1
#!/bin/sh
root=$(cd "$(dirname "$0")" && pwd)/root
export DCMDICTPATH="$root/usr/share/dcmtk/dicom.dic"
exec "$root/usr/lib64/ld-linux-x86-64.so.2" --library-path "$root/usr/lib/x86_64-linux-gnu:$root/usr/lib" \
    "$root/usr/sbin/Orthanc" "$@"
RUN
    chmod +x orthanc.new && mv orthanc.new orthanc || exit 1
)
