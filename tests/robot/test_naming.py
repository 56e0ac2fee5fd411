"""Names of files: each once, whatever the case of its letters, and none that some systems keep for themselves."""

from artipg_dsl.robot.naming import Names


def test_names_are_given_once() -> None:
    names = Names(["door"])
    assert [names(name) for name in ("door", "Door", "lid", "lid")] == ["door_2", "Door_3", "lid", "lid_2"]


def test_names_that_systems_keep_are_not_given_with_any_ending() -> None:
    names = Names()
    assert [names(name) for name in ("con", "con", "con.solid", "CON.solid", "aux.b.c")] == [
        "con_2",
        "con_3",
        "con_2.solid",
        "CON_3.solid",
        "aux_2.b.c",
    ]
    assert names("console") == "console"
