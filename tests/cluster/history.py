#!/usr/bin/python3
"""Judges what clients saw of an exercise against its log: a register to which
each command writes a name of its own, entity 1's.

    history.py HISTORY LOG

HISTORY is JSON, a list of {"name", "begun", "ended", "result"}, times by one
clock, result "done" (it was answered), "refused" (answered that it is not
done, at once) or "unknown" (the answer was lost, or said that it may be).
LOG is JSON, a list of {"number", "term", "names"}: the frames, and the names
that the commands of each write.

- A frame has the number after the one before; terms do not fall.
- Done: once in the log. Refused: not in it. Unknown: once at most. Nothing
  else is in it.
- What was answered before another was begun stands before it in the log.

Imports nothing of the project.
"""
import json
import sys


def judge(history, log):
    """Complaints, none if all is well."""
    complaints = []
    place = {}
    number = term = None
    for frame in log:
        if number is not None and frame["number"] != number + 1:
            complaints.append(f"frame {frame['number']} after {number}")
        if term is not None and frame["term"] < term:
            complaints.append(f"frame {frame['number']}: term {frame['term']} "
                              f"after {term}")
        number, term = frame["number"], frame["term"]
        for i, name in enumerate(frame["names"]):
            if name in place:
                complaints.append(f"{name} twice: in frames "
                                  f"{place[name][0]} and {number}")
            place.setdefault(name, (number, i))
    known = {command["name"]: command for command in history}
    for name in place:
        if name not in known:
            complaints.append(f"{name} in the log, of nobody")
    for name, command in known.items():
        if command["result"] == "done" and name not in place:
            complaints.append(f"{name} was answered, and is not in the log")
        if command["result"] == "refused" and name in place:
            complaints.append(f"{name} was refused, and is in the log")
    complaints += order(history, place)
    return complaints


def order(history, place):
    """By the times of begin and end: the newest place of all that had ended
    before a command began must be before its own."""
    done = sorted((c for c in history
                   if c["result"] == "done" and c["name"] in place),
                  key=lambda c: c["ended"])
    begun = sorted((c for c in history if c["name"] in place),
                   key=lambda c: c["begun"])
    complaints, newest, i = [], None, 0
    for command in begun:
        while i < len(done) and done[i]["ended"] < command["begun"]:
            if newest is None or place[done[i]["name"]] > place[newest]:
                newest = done[i]["name"]
            i += 1
        if newest and place[newest] >= place[command["name"]]:
            complaints.append(f"{command['name']} began after {newest} was "
                              "answered, and stands before it")
    return complaints


def main():
    with open(sys.argv[1]) as h, open(sys.argv[2]) as l:
        complaints = judge(json.load(h), json.load(l))
    print("\n".join(complaints[:20]) or "the log has what was answered, in "
          "order, once")
    return bool(complaints)


def self_test():
    """Each kind of wrong log is told."""
    def command(name, begun, ended, result="done"):
        return {"name": name, "begun": begun, "ended": ended, "result": result}

    def frames(*names, first=1):
        return [{"number": first + i, "term": 1, "names": list(n)}
                for i, n in enumerate(names)]
    history = [command("a", 0, 1), command("b", 2, 3), command("c", 2, 3),
               command("d", 4, 5, "refused"), command("e", 4, 5, "unknown")]
    good = frames(["a"], [], ["c", "b"], ["e"])
    assert judge(history, good) == [], judge(history, good)
    assert judge(history, frames(["a"], ["b", "c"])) == []
    for bad in (frames(["b"], ["a"], ["c"]), frames(["a"], ["b"]),
                frames(["a"], ["b", "c", "d"]), frames(["a"], ["b", "c", "b"]),
                frames(["a"], ["b", "c", "x"]), frames(["e"], ["a", "b", "c"]),
                frames(["a"]) + frames(["b", "c"], first=3)):
        assert judge(history, bad), bad


if __name__ == "__main__":
    if len(sys.argv) == 1:
        self_test()
        print("every kind of wrong log is told")
        sys.exit(0)
    sys.exit(main())
