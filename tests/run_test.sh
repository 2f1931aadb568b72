#!/bin/bash
# tests/run says at the end of its output what failed and why, however long the
# log of the failed test and wherever in it the failure stands. Tests run side by
# side, with folders and ports of their own, and their lines keep their order;
# what is left out is counted, and fails where CI is true.
set -u
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

make_test() { # name; its text on standard input
    { echo '#!/bin/bash'; cat; } >"$work/$1"
    chmod +x "$work/$1"
}

make_test cmocka <<'END'
seq -f '[ RUN      ] before_%g' 100
echo '[ RUN      ] waves'
echo '[  ERROR   ] --- 1 is not within 2 of 5'
echo '[   LINE   ] --- sea.c:7: error: Failure!'
seq -f '[       OK ] after_%g' 100
exit 1
END
make_test tap <<'END'
seq -f 'ok %g - before' 100
printf '%s\n' 'not ok 101 - swell' '  ---' '  error: |-' '    no picture came' \
    '  code: 1' '  ...'
seq -f 'ok %g - after' 102 200
exit 1
END
cat >"$work/python" <<'END'
#!/usr/bin/python3
import unittest

class Sea(unittest.TestCase):
    def test_calm(self):
        self.assertEqual("calm", "storm")

    def test_long(self):
        for i in range(100):
            print("line", i)

unittest.main()
END
chmod +x "$work/python"
make_test crash <<'END'
echo before
kill -SEGV $$
END
make_test hangs <<'END'
echo waiting for the tide
sleep 60
END
make_test fine <<'END'
exit 0
END
make_test left_out <<'END'
echo no ship here
exit 77
END

export TEST_LOGS=$work/logs
unset CI
said=$(tests/run "$work"/{cmocka,tap,python,crash,fine,left_out} 2>&1)
status=$?
end=$(tail -n 8 <<<"$said")

expect() { # words that one line of the end holds
    if ! grep -qF -- "$1" <<<"$end"; then
        echo "FAILED: the end does not say: $1"
        failed=1
    fi
}
expect 'FAILED: cmocka (status 1) — waves: 1 is not within 2 of 5 (sea.c:7'
expect 'FAILED: tap (status 1) — not ok 101 - swell: no picture came'
expect 'FAILED: python (status 1) — FAIL: test_calm'
expect "AssertionError: 'calm' != 'storm'"
expect 'FAILED: crash (SIGSEGV) — before'
if [ "$(tail -n 1 <<<"$said")" != '1 passed, 4 failed, 1 skipped' ]; then
    echo "FAILED: the last line is $(tail -n 1 <<<"$said")"
    failed=1
fi
if [ $status -ne 1 ]; then
    echo "FAILED: status $status"
    failed=1
fi
if [ $failed -ne 0 ]; then
    echo "$said"
fi

# Each waits for the others: one after the other they never end. What they
# leave behind goes with them.
for name in first second third; do
    make_test $name <<END
cd '$work'
echo "\$TMPDIR \$PELAGOS_TEST_PORTS" >$name.place
until [ -e first.place ] && [ -e second.place ] && [ -e third.place ]; do
    sleep 0.05
done
[ $name = first ] && sleep 0.5
sleep 600 &
echo \$! >$name.left
touch "\$TMPDIR/rest"
END
done
end=$(TEST_JOBS=3 TEST_TIMEOUT=60 tests/run "$work"/{first,second,third} 2>&1)
for word in first second third; do
    expect "  $word"
    state=$(cut -d ' ' -f 3 "/proc/$(cat "$work/$word.left")/stat" 2>/dev/null)
    if [ -n "$state" ] && [ "$state" != Z ]; then
        echo "FAILED: $word left a process"
        failed=1
    fi
done
if [ "$(awk '$1 == "ok" { print $4 }' <<<"$end" | xargs)" != \
    'first second third' ]; then
    echo "FAILED: the order is not that of the tests: $end"
    failed=1
fi
if [ "$(cat "$work"/*.place | tr ' ' '\n' | sort -u | wc -l)" -ne 6 ]; then
    echo "FAILED: tests share a folder or ports: $(cat "$work"/*.place)"
    failed=1
fi
for place in $(cut -d ' ' -f 1 "$work"/*.place); do
    if [ -e "$place" ]; then
        echo "FAILED: $place is left"
        failed=1
    fi
done

# What is left out, as each kind of test says it.
make_test cases <<'END'
echo '[  SKIPPED ] stars'
echo '[  SKIPPED ] 1 test(s), listed below:'
echo '[  SKIPPED ] stars'
echo 'ok 3 - tides # SKIP no Moon'
echo "test_pier (X) ... skipped 'no pier'" >&2
echo 'OK (skipped=2)' >&2
END
end=$(tests/run "$work"/{cases,left_out} 2>&1)
expect '1 passed, 0 failed, 5 skipped'
end=$(CI=true tests/run "$work"/{cases,left_out} 2>&1)
expect '0 passed, 2 failed, 0 skipped'
expect 'FAILED: left_out (skipped where CI=true: no ship here)'
expect 'FAILED: cases (skipped where CI=true: no pier; stars; no Moon)'
printf '%s\n' 'left_out 1 0.1 may-skip no ship -- ships are rare' \
    'cases 1 0.1 may-skip stars -- it is day' >"$work/schedule"
end=$(CI=true TEST_SCHEDULE=$work/schedule tests/run \
    "$work"/{left_out,cases} 2>&1)
expect 'no ship here [ships are rare]'
expect 'FAILED: cases (skipped where CI=true: no pier; stars; no Moon)'
expect '0 passed, 1 failed, 1 skipped'

# One that fails beside others and not alone is told, and passes.
make_test unsteady <<END
[ -e '$work/once' ] && exit 0
touch '$work/once'
echo the tide came early
exit 1
END
end=$(tests/run "$work"/{fine,unsteady} 2>&1)
expect 'again       0.0 s  unsteady: ok, alone'
expect 'UNSTEADY: unsteady, passed alone'
expect '2 passed, 0 failed, 0 skipped'
end=$(tests/run "$work"/{fine,cmocka} 2>&1)
expect 'cmocka: failed, alone too'
expect '1 passed, 1 failed, 0 skipped'

end=$(TEST_TIMEOUT=1 tests/run "$work/hangs" 2>&1 | tail -n 2)
expect 'FAILED: hangs (stopped after 1 s) — waiting for the tide'

# Reports of sanitizers count, of UBSan beside ASan too, even where a test
# throws away what a program says and does not look at how it ends.
cat >"$work/unsound.c" <<'END'
#include <stdlib.h>
int main(int count, char **words)
{
    static char *volatile kept;
    static volatile int most = 0x7fffffff;
    kept = malloc(7);
    kept[count == 2 ? 7 : 0] = words[0][0];
    most += count == 3;
    kept = NULL;
    return 0;
}
END
"${CC:-gcc}" -D_GNU_SOURCE -g -fsanitize=address,undefined "$work/unsound.c" \
    tests/lib/loading.c -o "$work/unsound"
make_test ignores <<END
for words in "" "1" "1 2"; do
    '$work/unsound' \$words >/dev/null 2>&1
done
exit 0
END
said=$(tests/sanitized asan "$work"/{fine,ignores} 2>&1)
[ $? -eq 1 ] || { echo 'FAILED: reports do not fail'; failed=1; }
end=$said
expect '2 passed, 0 failed, 0 skipped'
expect 'LeakSanitizer: detected memory leaks'
expect 'heap-buffer-overflow'
expect 'runtime error: signed integer overflow'
expect '2 tests under asan: 3 reports'
end=$(tests/sanitized asan "$work"/fine 2>&1 && echo passed)
expect '1 tests under asan: 0 reports'
expect 'passed'
if [ $failed -ne 0 ]; then
    echo "$end"
fi
exit $failed
