"""Series of numbers: one question at each combination of some axes' values."""
from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Union

from . import need
from .errors import MissingPackage

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

# An axis: its values, or a slice(first, last, step) whose last belongs to it.
Axis = Union[slice, Sequence[float]]


@dataclass(frozen=True)
class Series:
    """The answers, by name:

        s = ocean.series("water", {"wavelength": slice(400, 700, 10)})
        s.axes["wavelength"]           # float64, (31,)
        s["remoteSensingReflectance"]  # float64, (31,)
        s.dataset()                    # xarray's, for those who have it

    axes       values by name, those asked for first
    variables  arrays over their axes (`dims`); NaN where an answer has no number
    dims       names of each variable's axes
    units, texts, standard_names   of axes and variables
    """
    title: str
    history: str
    state: dict[str, Any] = field(repr=False)
    axes: "dict[str, NDArray[np.float64]]" = field(repr=False)
    variables: "dict[str, NDArray[np.float64]]" = field(repr=False)
    dims: dict[str, tuple[str, ...]]
    units: dict[str, str] = field(repr=False)
    texts: dict[str, str] = field(repr=False)
    standard_names: dict[str, str] = field(repr=False)

    def __getitem__(self, name: str) -> "NDArray[np.float64]":
        return self.axes[name] if name in self.axes else self.variables[name]

    @property
    def query(self) -> dict[str, Any]:
        """The question, as POST /v1/series takes it."""
        out: dict[str, Any] = json.loads(self.history.split(": ", 1)[1])
        return out

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> "Series":
        np = need.numpy()
        axes = {a["name"]: np.array(a["values"], np.float64)
                for a in content.get("axes", ())}
        lists = content.get("variables", ())
        named = [*content.get("axes", ()), *lists]
        return cls(
            content.get("title", ""), content.get("history", ""),
            json.loads(content.get("state", "{}")), axes,
            {v["name"]: np.array(v["values"], np.float64).reshape(
                [len(axes[a]) for a in v.get("axes", ())]) for v in lists},
            {v["name"]: tuple(v.get("axes", ())) for v in lists},
            {x["name"]: x["unit"] for x in named},
            {x["name"]: x.get("text", "") for x in named},
            {x["name"]: x["standardName"] for x in named
             if "standardName" in x})

    def dataset(self) -> Any:
        """An xarray.Dataset, each variable with units and long_name."""
        try:
            import xarray
        except ImportError:
            raise MissingPackage("datasets need xarray: apt install "
                                 "python3-xarray, or pip install xarray"
                                 ) from None

        def attributes(name: str) -> dict[str, str]:
            out = {"units": self.units[name], "long_name": self.texts[name]}
            if name in self.standard_names:
                out["standard_name"] = self.standard_names[name]
            return out
        return xarray.Dataset(
            {name: (self.dims[name], v, attributes(name))
             for name, v in self.variables.items()},
            {name: (name, v, attributes(name)) for name, v in self.axes.items()},
            {"title": self.title, "history": self.history})


def axes_of(sweep: Mapping[str, Axis]) -> list[dict[str, Any]]:
    """As the schema's Sweep has them."""
    out = []
    for name, axis in sweep.items():
        if isinstance(axis, slice):
            one = {"over": name, "first": axis.start or 0, "last": axis.stop,
                   "step": axis.step}
            out.append({k: v if k == "over" else float(v)
                        for k, v in one.items() if v is not None})
        else:
            out.append({"over": name, "values": [float(v) for v in axis]})
    return out
