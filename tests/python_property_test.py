#!/usr/bin/python3
"""What must hold of the Python client and the daemon for any values, by
Hypothesis: numbers survive, refusals leave all as it was, other fields stay,
records and patches round trip. PROPERTY_EXAMPLES (150) of each, the same in
every run; PROPERTY_SEED=N: others."""
import math
import os
import sys
import tempfile
import unittest

import hypothesis
import hypothesis.configuration
from hypothesis import given, settings
from hypothesis import strategies as st

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, Daemon

sys.path.insert(0, os.path.join(ROOT, "clients/python"))
sys.dont_write_bytecode = True
import pelagos
from pelagos import Ocean
from pelagos.schema import State

hypothesis.configuration.set_hypothesis_home_dir(
    os.path.join(tempfile.gettempdir(), "hypothesis"))
EXAMPLES = int(os.environ.get("PROPERTY_EXAMPLES", "150"))
SEED = os.environ.get("PROPERTY_SEED")
often = settings(max_examples=EXAMPLES, deadline=None, database=None,
                 derandomize=SEED is None,
                 suppress_health_check=list(hypothesis.HealthCheck))


def seeded(test):
    return hypothesis.seed(int(SEED))(test) if SEED else test


def shown(state):
    """All but what each edit counts on."""
    state = dict(state)
    state.pop("revision")
    return state


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.ocean = Ocean(cls.daemon.url(""))
        cls.fresh = {
            "clock": {"mode": "STEPPED", "time": 5},
            "sea": {"synthesiser": "TROCHOIDS"}, "sky": None, "water": None,
            "entities": [{"id": 1, "name": "ownship"}],
            "views": [{"name": "bridge", "entity": 1}]}
        cls.ocean.patch(cls.fresh)
        # What may be any number of its range, by itself.
        cls.ranges = {
            path: (field["minimum"], field["maximum"])
            for path, field in cls.ocean.fields().items()
            if "minimum" in field and "values" not in field
            and not path.endswith("Time")  # poses are reckoned to it
            and path.split(".")[0] in ("sky", "water", "entities", "views")
            and path.count(".") == (2 if ".*." in path else 1)}
        cls.plain = sorted(path for path in cls.ranges if cls.is_plain(path))

    @classmethod
    def is_plain(cls, path):
        """Whether it takes fractions: not the whole numbers."""
        low, high = cls.ranges[path]
        place = path.replace("entities.*", "entities.1").replace(
            "views.*", "views.bridge")
        try:
            cls.ocean[place] = low + (high - low) * 0.377
        except pelagos.Refused:
            return False
        cls.ocean[place] = None
        return True

    @classmethod
    def tearDownClass(cls):
        cls.ocean.close()
        assert cls.daemon.stop() == 0

    def json(self):
        return self.ocean.transport.request("GET", "/v1/state").json()

    def place(self, data):
        self.ocean.patch(self.fresh)
        path = data.draw(st.sampled_from(self.plain))
        low, high = self.ranges[path]
        return (path.replace("entities.*", "entities.1")
                .replace("views.*", "views.bridge"), low, high)


class Numbers(Case):
    @seeded
    @often
    @given(st.data())
    def test_a_number_survives(self, data):
        """Each double comes back as it was given, and no other has changed."""
        place, low, high = self.place(data)
        value = data.draw(st.floats(low, high) | st.sampled_from([low, high]))
        before = self.json()
        try:
            after = self.ocean.set(**_nested(place, value))
        except pelagos.Refused as refused:  # not beside what is there
            self.assertNotIsInstance(refused, pelagos.OutOfRange, place)
            self.assertEqual(self.json(), before)
            return
        self.assertEqual(self.ocean[place], value, place)
        self.assertEqual(int(after.revision), int(before["revision"]) + 1)
        self.assertEqual(_differences(shown(before), shown(self.json()))
                         - {place}, set(), place)

    @seeded
    @often
    @given(st.data())
    def test_what_is_out_of_range_changes_nothing(self, data):
        place, low, high = self.place(data)
        value = data.draw(
            st.floats(max_value=low, exclude_max=True, allow_infinity=False)
            | st.floats(min_value=high, exclude_min=True,
                        allow_infinity=False))
        before = self.json()
        with self.assertRaises(pelagos.Refused) as caught:
            # The half that would do is not done either.
            self.ocean.patch({**_nested(place, value),
                              "clock": {"rate": 7}})
        self.assertIn(place.split(".")[-1], str(caught.exception))
        self.assertEqual(self.json(), before)

    @seeded
    @often
    @given(st.data(), st.sampled_from([math.nan, math.inf, -math.inf]) |
           st.text("abc-. äö", max_size=9) | st.binary(max_size=5) | st.lists(st.integers(),
                                                                 max_size=2))
    def test_what_is_no_number_changes_nothing(self, data, value):
        place, _, _ = self.place(data)
        before = self.json()
        with self.assertRaises((pelagos.PelagosError, ValueError, TypeError)):
            self.ocean[place] = value
        self.assertEqual(self.json(), before)


def _nested(place, value):
    for part in reversed(place.split(".")):
        value = {part: value}
    return value


def _leaves(value, path=""):
    if isinstance(value, dict):
        for name, part in value.items():
            yield from _leaves(part, f"{path}.{name}".lstrip("."))
    elif isinstance(value, list):
        for i, part in enumerate(value):
            key = part.get("name" if path == "views" else "id", i) \
                if isinstance(part, dict) else i
            yield from _leaves(part, f"{path}.{key}")
    else:
        yield path, value


def _differences(before, after):
    one, other = dict(_leaves(before)), dict(_leaves(after))
    return {path for path in one.keys() | other.keys()
            if one.get(path) != other.get(path)}


class Patches(Case):
    @seeded
    @often
    @given(st.lists(st.tuples(
        st.sampled_from(["entities", "views"]), st.integers(0, 2),
        st.none() | st.fixed_dictionaries({}, optional={
            "yaw": st.floats(-180, 180), "heading": st.floats(0, 359.9),
            "name": st.text("abcXYZ äö", min_size=1, max_size=9)})),
        max_size=6))
    def test_lists_are_what_a_dictionary_would_be(self, changes):
        """Elements come, change and go by their keys, each alone."""
        model = {"entities": {}, "views": {}}
        self.ocean.patch(self.fresh)
        for part, which, fields in changes:
            key = ("x", "2", "3")[which] if part == "entities" \
                else ("x", "a", "b")[which]
            wanted = "yaw" if part == "views" else "heading"
            if fields is not None:
                fields = {name: value for name, value in fields.items()
                          if name == wanted
                          or (name == "name" and part == "entities")}
            before = self.json()
            try:
                self.ocean.patch({part: {key: fields}})
            except pelagos.Refused:
                self.assertTrue(key == "x" or (fields is None
                                               and key not in model[part]))
                self.assertEqual(self.json(), before)
                continue
            if key == "x":  # a view may have any name
                self.ocean.patch({part: {key: None}})
            elif fields is None:
                model[part].pop(key, None)
            else:
                model[part].setdefault(key, {}).update(fields)
        state = self.json()
        for part, name in (("entities", "id"), ("views", "name")):
            there = {str(e[name]): e for e in state[part]}
            self.assertEqual(there.keys() - {"1", "bridge"},
                             model[part].keys())
            for key, fields in model[part].items():
                for field, value in fields.items():
                    self.assertEqual(there[key][field], value)

    @seeded
    @often
    @given(st.data())
    def test_a_state_goes_there_and_back(self, data):
        """As records, and as a patch of all of it."""
        for _ in range(3):
            place, low, high = self.place(data)
            try:
                self.ocean[place] = data.draw(st.floats(low, high))
            except pelagos.Refused:
                pass
        before = self.json()
        records = State.from_json(before)
        again = records.to_json()
        self.assertEqual(State.from_json(again), records)
        with self.ocean.kept():
            place, low, high = self.place(data)
            try:
                self.ocean[place] = data.draw(st.floats(low, high))
            except pelagos.Refused:
                pass
        self.assertEqual(shown(self.json()), shown(before))

    @seeded
    @often
    @given(st.integers(0, 5), st.floats(0, 100))
    def test_an_old_revision_changes_nothing(self, age, rate):
        before = self.json()
        revision = int(before["revision"]) - age
        try:
            self.ocean.patch({"clock": {"rate": rate}}, revision=revision)
            self.assertEqual(age, 0)
            self.assertEqual(self.ocean["clock.rate"], rate)
        except pelagos.Conflict:
            self.assertGreater(age, 0)
            self.assertEqual(self.json(), before)

    @seeded
    @often
    @given(st.lists(st.text(max_size=6), max_size=4))
    def test_any_path_is_read_or_refused(self, parts):
        path = ".".join(parts)
        before = self.json()
        try:
            self.ocean[path]
        except (LookupError, ValueError, pelagos.PelagosError):
            pass
        self.assertEqual(self.json(), before)


if __name__ == "__main__":
    unittest.main(verbosity=2)
