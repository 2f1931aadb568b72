"""What every test of HTTP begins with."""
import json
import unittest

from pelagos_daemon import SLOW_S, Daemon, until


def without_time(state):
    state = json.loads(json.dumps(state))
    state["clock"].pop("time", None)
    return state


class HttpCase(unittest.TestCase):
    daemon = None

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        # Compiling for the first pictures takes long enough on a busy machine
        # for the watchdog to speak of it.
        cls.daemon.get("/v1/views/bridge/frame.jpg?width=64&height=36",
                       timeout=SLOW_S)
        until("well", lambda: cls.daemon.get("/healthz").status == 200)

    @classmethod
    def tearDownClass(cls):
        status = cls.daemon.stop()
        assert status == 0, f"the daemon ended with {status}"

    def setUp(self):
        self.daemon.patch({"clock": None, "sea": None, "sky": None, "views": [
            {"name": "bridge", "entity": 1, "width": 320, "height": 180}]})
        self.before = without_time(self.daemon.state())

    def refused(self, response, status, **members):
        """It is problem+json with these members, and nothing has changed."""
        self.assertEqual(response.status, status, response)
        self.assertEqual(response.headers["Content-Type"],
                         "application/problem+json")
        problem = response.json()
        self.assertEqual(problem["status"], status)
        self.assertTrue(problem["title"] and problem["detail"], problem)
        for name, value in members.items():
            self.assertEqual(problem.get(name), value, problem)
        self.assertEqual(without_time(self.daemon.state()), self.before)
        return problem
