#!/usr/bin/env python3
"""interrupt_test.py: Ctrl-C ends a fit that would take minutes, as KeyboardInterrupt, and the next one works."""
import os
import signal
import sys
import threading
import time

try:
    import facetfit
except ImportError as missing:
    print("skipped: " + str(missing))
    sys.exit(0)


def interrupted(work):
    """Seconds from the signal to the exception; None where there is none."""
    sent = [0.0]

    def send():
        sent[0] = time.monotonic()
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, send)
    timer.start()
    try:
        work()
    except KeyboardInterrupt:
        return time.monotonic() - sent[0]
    finally:
        timer.cancel()
        timer.join()
    return None


def main():
    data = facetfit.simulate("ggx+lambert", "goniometer:3", relative=0.02, alpha=0.3)
    taken = [
        interrupted(lambda: facetfit.fit(data, bootstrap=1000000)),
        interrupted(lambda: [facetfit.compare(data) for _ in range(1000)]),
        interrupted(lambda: facetfit.fit(data).plot("bootstrap", bootstrap=1000000)),
    ]
    print("seconds until it ended:", taken)
    after = facetfit.fit(data).converged
    return not (after and all(t is not None and t < 20 for t in taken))


if __name__ == "__main__":
    sys.exit(main())
