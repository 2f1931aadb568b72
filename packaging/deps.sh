#!/bin/sh
# Installs the Debian packages named as arguments that are not there yet.
# Quiet and quick when nothing is missing; DEPS=skip does nothing.
set -eu

if [ "${DEPS:-}" = skip ]; then
    exit 0
fi

say_by_hand() {
    echo "deps: $1" >&2
    echo "Pelagos needs these packages (Debian 12 names):" >&2
    echo "$2" | fold -s -w 72 | sed 's/^/    /' >&2
    echo "Install them, then go on with DEPS=skip." >&2
    exit 1
}

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    say_by_hand "this system has no apt-get." "$*"
fi

present=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' "$@" \
    2>/dev/null | awk '$2 == "installed" { print $1 }') || true
missing=
for package in "$@"; do
    case "
$present
" in
    *"
$package
"*) ;;
    *) missing="$missing $package" ;;
    esac
done
if [ -z "$missing" ]; then
    exit 0
fi
missing=${missing# }

if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null &&
    { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
    as_root=sudo
else
    say_by_hand "missing packages, and neither root nor sudo to install them." \
        "$missing"
fi

# A mirror may hiccup, another apt-get may be at work.
apt_get() {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq \
        -o Acquire::Retries=3 -o DPkg::Lock::Timeout=600 "$@" </dev/null
}

echo "deps: missing, installed by apt-get now (DEPS=skip: not): $missing"
apt_get update ||
    echo "deps: apt-get update failed; trying with the lists that are here" >&2
apt_get -y --no-install-recommends install $missing >/dev/null ||
    say_by_hand "apt-get could not install them." "$missing"
