"""Data sets of millions of labelled frames: drawn from a plan by any number of
workers, whole whatever dies. `pelagosctl dataset` is its command line,
docs/datasets.md its manual."""
from .fields import BadPlan
from .plan import Plan, Scene, read_plan

__all__ = ["BadPlan", "Plan", "Scene", "read_plan"]
