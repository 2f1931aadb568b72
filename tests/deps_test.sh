#!/bin/bash
# packaging/deps.sh installs what is missing and nothing else, and say
# so first. With stand-ins for dpkg-query, apt-get and id.
set -u
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

make_tool() { # name; its text on standard input
    { echo '#!/bin/bash'; cat; } >"$work/bin/$1"
    chmod +x "$work/bin/$1"
}

mkdir "$work/bin"
make_tool dpkg-query <<'END2'
for word; do
    case $word in
    here*) echo "$word installed" ;;
    half*) echo "$word config-files" ;;
    esac
done
exit 1 # some are not known to it
END2
make_tool apt-get <<END2
echo "apt-get \$*"
END2
make_tool id <<'END2'
echo 0
END2
said() { # what was said, and done
    PATH=$work/bin:$PATH DEPS= "$@" 2>&1
}
check() { # what it should be, what it is
    if [ "$1" != "$2" ]; then
        printf 'FAILED: %s\nis not: %s\n' "$2" "$1"
        failed=1
    fi
}

check '' "$(said packaging/deps.sh here here-too)"
text=$(said packaging/deps.sh here half gone here-too)
check 'deps: missing, installed by apt-get now (DEPS=skip: not): half gone' \
    "$(head -n 1 <<<"$text")"
check 1 "$(grep -c '^apt-get .*update' <<<"$text")"
# Output of the installation itself is not shown: only that of a failure.
make_tool apt-get <<END2
[[ "\$*" == *update* ]] || echo "\$*" >"$work/installed"
END2
said packaging/deps.sh here half gone here-too >/dev/null
check 'half gone' "$(grep -o 'half.*' "$work/installed")"
check '' "$(DEPS=skip packaging/deps.sh gone)"
make_tool apt-get <<END2
[[ "\$*" == *update* ]] && exit 0
echo "E: Unable to locate package gone" >&2
exit 100
END2
text=$(said packaging/deps.sh gone)
check 1 $?
check 1 "$(grep -c 'Unable to locate' <<<"$text")"
check '    gone' "$(grep '^    ' <<<"$text")"

exit $failed
