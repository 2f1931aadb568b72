#!/usr/bin/python3
"""A CIGI host at 60 Hz for SOAK_SECONDS (600), synchronous, and a tenth of
that asynchronous in the other byte order, and a tenth over a sea of FFT: each host frame moves the ship
and asks 100 heights, and a small view is watched. No host frame may stay
unanswered, 95 % of the pictures must show one of the last two host frames,
the daemon must not grow, and tshark must have no note on the last 20,000
datagrams."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)),
                                os.pardir))
import cigi_test  # noqa: E402

SECONDS = float(os.environ.get("SOAK_SECONDS", "600"))
MOST_GROWTH = 8 << 20  # of the allocator's arenas; 36,000 frames leave nothing


def host(seconds, late=0.05, **kind):
    grown = cigi_test.host_at_sixty_hertz(seconds, late=late, **kind)
    print(f"  grown by {grown / (1 << 20):.1f} MiB after the warm-up",
          flush=True)
    if not cigi_test.SANITIZED and seconds >= 60:  # 12 s of warm-up
        cigi_test.check(grown <= MOST_GROWTH, f"grown by {grown} bytes")


def main():
    host(SECONDS)
    host(max(SECONDS / 10, 5), stamped=True, big=False, minor=2)
    host(max(SECONDS / 10, 5), late=1, fft=True)  # figures without a bar
    cigi_test.tshark_understands_both_directions(20000)


if __name__ == "__main__":
    main()
