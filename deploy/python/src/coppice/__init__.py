"""Coppice from Python: record what a policy does, hand a problem over, act by the tree that comes back.

    coppice.record(env, policy, episodes, "log.jsonl")   writes a log that `coppice import` reads
    coppice.tables(env, "lake.json")                     writes the transition table of a toy-text environment
    coppice.Tree.load("policy.json")(observation)        acts as `coppice export` wrote
    coppice.Study("lake.coppice")                        reads figures, front and trees into arrays

`python -m coppice.gym ENV` is the simulator that `coppice score --simulator` talks to.
"""

from coppice.errors import CoppiceError
from coppice.minari import from_minari
from coppice.recording import record
from coppice.simulator import serve
from coppice.spaces import Problem, problem_of
from coppice.study import Front, Run, Study
from coppice.tabular import tables
from coppice.tree import Tree

__all__ = [
    "CoppiceError",
    "Front",
    "Problem",
    "Run",
    "Study",
    "Tree",
    "from_minari",
    "problem_of",
    "record",
    "serve",
    "tables",
]
__version__ = "0.1.0"
