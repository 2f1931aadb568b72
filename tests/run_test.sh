#!/bin/bash
# tests/run says at the end of its output what failed and why, however long the
# log of the failed test and wherever in it the failure stands.
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

end=$(TEST_TIMEOUT=1 tests/run "$work/hangs" 2>&1 | tail -n 2)
expect 'FAILED: hangs (stopped after 1 s) — waiting for the tide'
if [ $failed -ne 0 ]; then
    echo "$end"
fi
exit $failed
