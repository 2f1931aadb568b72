#!/bin/bash
# The Debian packages, those in the folder $1 or of the programs as they are
# built here: lintian has nothing to say; installed in a copy of this system
# that is thrown away the programs, the library and the Python client work; the
# unit runs under systemd with all of its sandbox, draws, streams H.264, reads a
# file of heights, is started again by its watchdog and keeps the scene; after a
# purge nothing is left.
set -u
cd "$(dirname "$0")/../.."
if [ -z "${PELAGOS_DEB_INSIDE:-}" ]; then
    if ! unshare -m --propagation private true 2>/dev/null ||
        [ "$(id -u)" != 0 ]; then
        echo "not root with CAP_SYS_ADMIN: no root to install in"
        exit 77
    fi
    exec env PELAGOS_DEB_INSIDE=1 unshare -m --propagation private "$0" "$@"
fi
unset MAKEFLAGS MAKELEVEL PELAGOS_BIN
work=$(mktemp -d)
version=$(cat VERSION)
abi=${version%.*}
init= cgroup=
cleanup() {
    [ -z "$init" ] || kill -KILL "$init" 2>/dev/null
    umount -lR "$work/root" "$work/upper" 2>/dev/null
    if [ -n "$cgroup" ]; then
        for _ in $(seq 50); do # until what was killed is gone
            find "$cgroup" -depth -type d -exec rmdir {} + 2>/dev/null
            [ -e "$cgroup" ] || break
            sleep 0.1
        done
    fi
    rm -rf "$work"
}
trap cleanup EXIT
fail() {
    echo "FAILED: $*"
    exit 1
}
wait_for() {
    for _ in $(seq 3000); do
        "$@" >/dev/null 2>&1 && return 0
        sleep 0.1
    done
    return 1
}

# --- the packages -------------------------------------------------------------
debs=${1:-}
if [ -z "$debs" ]; then
    debs=$work/debs
    words() { make -s --eval="words: ; @echo \$($1)" words; }
    dev=
    for try in '' 1; do # as what is here was built
        [ "$(make -s DEV=$try --eval='key: ; @echo $(KEY)' key)" != \
            "$(cat build/release/flags)" ] || dev=$try
    done
    PELAGOS_AS_BUILT=1 PELAGOS_DEV=$dev DEB_BUILD_PROFILES=nodoc \
        packaging/deb.sh "$debs" "$(words BUILD_PACKAGES)" \
        "$(words SITE_PACKAGES)" "$(words THIRD)" $(words EMBEDDED) >/dev/null || fail "no packages"
    grep -E '^  (CC|LINK) ' "$debs/build.log" && fail "something was built anew"
fi
debs=$(cd "$debs" && pwd)
lintian --allow-root --fail-on error,warning "$debs"/pelagos_*.changes ||
    fail "lintian"
for name in pelagosd pelagosctl "libpelagos$abi" libpelagos-dev python3-pelagos; do
    deb=$(ls "$debs/${name}_$version"_*.deb) || fail "no $name"
    [ "$(dpkg-deb -f "$deb" Version)" = "$version" ] || fail "$deb: version"
done
grep -q "^pelagos ($version)" "$debs/pelagos-$version/debian/changelog" ||
    fail "changelog"
dpkg-deb -I "$debs/libpelagos${abi}_${version}"_*.deb symbols |
    grep -q "PELAGOS_$abi" || fail "no symbols file"
dpkg-deb -f "$debs/pelagosctl_${version}"_*.deb Depends | grep -q libepoxy &&
    fail "the command line needs GL"
echo "ok packages"

# --- a root to throw away: this system below, what is written in memory ----------
root=$work/root
mkdir "$root" "$work/upper"
mount -t tmpfs upper "$work/upper" && mkdir "$work/upper/"{files,work} &&
    mount -t overlay -o "lowerdir=/,upperdir=$work/upper/files,workdir=$work/upper/work" \
        overlay "$root" || { echo "no overlay can be mounted here"; exit 77; }
mount -t tmpfs tmp "$root/tmp"
mount --bind /dev "$root/dev"
mount -t proc proc "$root/proc"
mkdir "$root/tmp/debs"
for deb in "$debs"/*.deb; do
    case $deb in *-dbgsym_*) ;; *) cp "$deb" "$root/tmp/debs" ;; esac
done
printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d"
chmod +x "$root/usr/sbin/policy-rc.d"
at() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
    LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
at sh -c 'dpkg -i /tmp/debs/*.deb' >"$work/log" 2>&1 ||
    fail "dpkg: $(tail "$work/log")"
[ "$(at pelagosd --version)" = "pelagosd $version" ] || fail "pelagosd"
[ "$(at pelagosctl --version)" = "pelagosctl $version" ] || fail "pelagosctl"
at pelagosd --check --config /etc/pelagos/pelagosd.conf || fail "key file"
[ "$(at sh -c 'cd / && python3 -c "import pelagos; print(pelagos.__version__, pelagos.__file__)"')" = \
    "$version /usr/lib/python3/dist-packages/pelagos/__init__.py" ] || fail "python"
cat >"$root/tmp/use.c" <<'END'
#include <pelagos.h>
int main(void) { return pel_client_code_name(PEL_CLIENT_BUSY) == NULL; }
END
# shellcheck disable=SC2016
at sh -c 'cc /tmp/use.c -o /tmp/use $(pkg-config --cflags --libs pelagos) &&
    /tmp/use && ldd /tmp/use | grep -q /libpelagos' || fail "libpelagos-dev"
at getent passwd pelagos >/dev/null && at getent group render >/dev/null ||
    fail "no user, or no group"
for page in usr/share/man/man8/pelagosd.8.gz usr/share/man/man1/pelagosctl.1.gz \
    usr/share/bash-completion/completions/pelagosctl \
    usr/share/zsh/vendor-completions/_pelagosctl \
    usr/share/fish/vendor_completions.d/pelagosctl.fish \
    etc/systemd/system/multi-user.target.wants/pelagosd.service; do
    [ -e "$root/$page" ] || [ -L "$root/$page" ] || fail "no $page"
done
echo "ok installed"

# --- the unit, by systemd as the first process ------------------------------------
base=$(awk '$3 == "cgroup2" { print $2; exit }' /proc/mounts)
if [ -n "$base" ] && mkdir "$base/pelagos-test-$$" 2>/dev/null; then
    cgroup=$base/pelagos-test-$$
    # A busy machine may take its time to start; nothing else is changed.
    mkdir -p "$root/etc/systemd/system/pelagosd.service.d" "$root/srv/heights"
    printf '[Service]\nTimeoutStartSec=600\nWatchdogSec=60\n' \
        >"$root/etc/systemd/system/pelagosd.service.d/test.conf"
    sed -i 's,^state=.*,&\nbathymetry=/srv/heights,' \
        "$root/etc/pelagos/pelagosd.conf"
    { printf 'ncols 9\nnrows 9\nxllcorner 5.0\nyllcorner 52.4\ncellsize 0.05\n'
      yes -- '-17 -17 -17 -17 -17 -17 -17 -17 -17' | head -n 9
    } >"$root/srv/heights/flat.asc"
    (
        echo $BASHPID >"$cgroup/cgroup.procs" || exit 1
        exec unshare -m -p -f -u -i -n -C --propagation private \
            tests/lib/boot_root.sh "$root" basic.target
    ) >"$work/boot" 2>&1 </dev/null &
    outer=$!
    find_init() { init=$(pgrep -P "$outer" -f ^/lib/systemd/systemd); }
    wait_for find_init || fail "systemd does not start: $(cat "$work/boot")"
    in_() { nsenter -t "$init" -m -p -C -n -u -i -r -w env -i \
        PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 "$@"; }
    wait_for in_ systemctl is-active basic.target ||
        fail "systemd: $(in_ systemctl list-jobs --no-pager)"
    daemon() { in_ systemctl show --value -p "$1" pelagosd; }
    said() { in_ journalctl --no-pager -q -u pelagosd | tail -n 20; }
    in_ systemctl start pelagosd || fail "the unit: $(said)"
    echo "ok the unit starts"

    pid=$(pgrep -f '^/usr/bin/pelagosd --config /etc/pelagos' --ns "$init" \
        --nslist pid | head -n 1)
    grep -qE '^Seccomp:\s*2' "/proc/$pid/status" &&
        grep -qE '^NoNewPrivs:\s*1' "/proc/$pid/status" &&
        grep -qE '^CapBnd:\s*0+$' "/proc/$pid/status" &&
        [ "$(wc -l <"/proc/$pid/uid_map")" = 2 ] || fail "no sandbox"
    # What the daemon sees: a read-only system, no homes, no tmp of others.
    sees() { nsenter -t "$pid" -m "$@"; }
    sees touch /usr/x 2>/dev/null && fail "it may write to /usr"
    [ -z "$(sees ls -A /root 2>/dev/null)" ] || fail "it sees homes"
    touch "/proc/$init/root/tmp/others"
    sees test -e /tmp/others && fail "it sees the tmp of others"
    [ "$(stat -c %U "/proc/$pid")" != root ] || fail "it is root"
    echo "ok in its sandbox"

    ctl() { in_ pelagosctl --server unix:/run/pelagos/pelagosd.sock "$@"; }
    ctl frame bridge /run/bridge.png --width 320 --height 180 ||
        fail "no picture: $(said)"
    in_ cat /run/bridge.png | head -c 4 | grep -q PNG || fail "no PNG"
    in_ sh -c 'timeout 300 curl -s http://127.0.0.1:8080/v1/views/bridge/ts |
        head -c 100000' >"$work/stream.ts"
    ffprobe -v error -show_entries stream=codec_name -of csv=p=0 \
        "$work/stream.ts" | grep -q h264 || fail "no H.264: $(said)"
    echo "ok draws and streams"
    ctl set seabed.file=flat.asc sea.windSpeed=13.5 || fail "heights: $(said)"
    depth=$(in_ curl -s -H 'Content-Type: application/json' \
        -d '{"points":[[0,0]]}' http://127.0.0.1:8080/v1/surface)
    echo "$depth" | grep -q '"depth":17\|"depth": 17' ||
        fail "no depth of 17 m: $depth"
    echo "ok reads heights"

    # What hangs is ended by the watchdog and started again, with its scene.
    kill -STOP "$pid"
    again() { [ "$(daemon NRestarts)" = 1 ] && [ "$(daemon ActiveState)" = active ]; }
    wait_for again || wait_for again || fail "no restart: $(said)"
    in_ journalctl --no-pager -q -u pelagosd | grep -q 'Watchdog timeout' ||
        fail "not by the watchdog: $(said)"
    [ "$(ctl get sea.windSpeed | grep -o '13\.5')" = 13.5 ] ||
        fail "the scene is lost: $(ctl get sea.windSpeed)"
    in_ systemctl stop pelagosd
    [ "$(daemon Result)" = success ] || fail "does not end well: $(said)"
    echo "ok the watchdog starts it again, with its scene"
    kill -KILL "$init"
    wait "$outer" 2>/dev/null
    init=
    rm -r "$root/etc/systemd/system/pelagosd.service.d" "$root/srv/heights"
else
    echo "no cgroup to boot in: the unit is left out"
    skipped=1
fi

# --- nothing is left -------------------------------------------------------------
[ -n "${skipped:-}" ] || [ -d "$root/var/lib/private/pelagos" ] ||
    fail "where is the scene?"
at sh -c "dpkg --purge pelagosd pelagosctl libpelagos-dev libpelagos$abi \
    python3-pelagos pelagos-doc" >"$work/log" 2>&1 || fail "purge: $(cat "$work/log")"
grep 'not empty so not removed' "$work/log" && fail "purge leaves folders"
# In the layer that was written a file that is gone again has left no trace.
left=$(cd "$work/upper/files" && find . -iname '*pelagos*' ! -path './proc/*')
[ -z "$left" ] || fail "left: $left"
echo "ok purged"
[ -z "${skipped:-}" ] || exit 77
