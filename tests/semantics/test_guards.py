"""Conditions over discrete facts: what follows from what, and what can hold together."""

from artipg_dsl.semantics.guards import (
    TRUE,
    And,
    Atom,
    Compare,
    Not,
    Or,
    assignments,
    conjunction,
    consistent,
    implies,
    possible,
)

KINDS = ("drawer", "door", None)


def part(*allowed: str | None, key: str = "front") -> Atom:
    return Atom(key, frozenset(allowed), KINDS)


def test_a_kind_of_part_implies_its_presence():
    there = part("drawer", "door")
    assert implies(part("drawer"), there)
    assert not implies(there, part("drawer"))
    assert not implies(TRUE, there)


def test_the_else_branch_of_a_kind_leaves_the_others():
    assert possible(Not(part("drawer")), "front", KINDS) == {"door", None}
    assert possible(And((part("drawer", "door"), Not(part("drawer")))), "front", KINDS) == {"door"}


def test_ranks_and_counts_are_never_negative():
    first = Compare("rank", "==", 0)
    assert implies(Not(first), Compare("rank", ">", 0))
    assert implies(Compare("rank", "!=", 0), Compare("rank", ">=", 1))
    assert not consistent(Compare("rank", "<", 0))


def test_counts_are_compared_across_constants():
    assert not consistent(Compare("n", "==", 1), Compare("n", "==", 2))
    assert implies(Compare("n", ">", 4), Compare("n", ">=", 3))
    assert not implies(Compare("n", ">=", 3), Compare("n", ">", 4))


def test_variables_are_independent_of_each_other():
    a, b = part("drawer", key="a"), part("door", key="b")
    assert consistent(a, b)
    assert not implies(a, b)
    assert implies(And((a, b)), Or((b, part("door", key="a"))))


def test_conjunction_drops_repetition_and_nesting():
    a, b = part("drawer"), Compare("n", ">", 0)
    assert conjunction((a, And((a, b)), TRUE)) == And((a, b))
    assert conjunction((a,)) is a
    assert conjunction(()) == TRUE


def test_too_many_cases_are_left_alone():
    atoms = tuple(Atom(f"v{i}", frozenset((True,)), (True, False)) for i in range(40))
    assert assignments(And(atoms)) is None
    assert consistent(*atoms)
    assert implies(And(atoms), Compare("n", ">", 3))  # nothing is claimed against it
