#!/bin/sh
# build.sh OPENAPI.json MANUALS SITE: the documentation as HTML in the folder
# SITE. A link that leads nowhere, or any other warning, is a failure.
set -eu
cd "$(dirname "$0")/../.."
work=$3.source
PELAGOS_TREE=$PWD
export PELAGOS_TREE PYTHONDONTWRITEBYTECODE=1
/usr/bin/python3 packaging/site/prepare.py . "$1" "$2" "$work"
rm -rf "$3"
/usr/bin/python3 -m sphinx -q -E -W --keep-going -b html -d "$work/doctrees" \
    "$work" "$3"
rm -f "$3/objects.inv" "$3/.buildinfo"
/usr/bin/python3 packaging/site/links.py "$3"
rm -rf "$work"
