"""Who yields: greedy matching and evaluation order."""

from artipg_dsl.graph.matching import components, match


def test_the_preferred_unknowns_are_determined():
    # unknowns 0, 1 stand in equation 0; 1, 2 in equation 1
    result = match([[0], [0, 1], [1]], 2, order=[2, 0, 1])
    assert result.equation_of == [0, -1, 1]
    result = match([[0], [0, 1], [1]], 2, order=[1, 2, 0])
    assert result.equation_of[1] >= 0 and result.equation_of[2] >= 0 and result.equation_of[0] < 0


def test_later_choices_never_undo_earlier_ones():
    result = match([[0, 1], [0], [1]], 2, order=[0, 1, 2])
    assert result.equation_of[0] >= 0 and result.equation_of[1] == 0


def test_exchange_finds_what_a_free_unknown_could_replace():
    result = match([[0], [0, 1], [1]], 2, order=[0, 1, 2])
    assert result.exchangeable(2) == [0, 1]


def test_free_equations_are_listed():
    assert match([[0, 1]], 2, order=[0]).free_equations == [1]


def test_components_come_in_the_order_of_evaluation():
    # 0 needs 1; 1 and 2 need each other; 3 needs 0
    assert components([0, 1, 2, 3], [{1}, {2}, {1}, {0}]) == [[1, 2], [0], [3]]
