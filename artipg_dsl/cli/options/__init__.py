"""The options of every command, apart from what runs it, so that ``--help`` loads nothing else.

In: the parser of a command. Out: ``COMMANDS``, by name: what the command does, and what adds its options. Begin with that table.

    texts, samples    programs as text; `apgc sample`
    folders, figures  folders of objects; pictures and figures
    real              real objects
    shared            what several commands share, under one name and with one meaning
"""

from .figures import add_profile, add_render, add_report, add_validate
from .folders import add_export, add_layout, add_mutate
from .real import add_bind, add_compare, add_fit
from .samples import add_sample
from .texts import add_cache, add_check, add_compile, add_explain, add_fmt, add_ledger, add_lsp, add_new, add_watch

COMMANDS = {
    "new": ("create a category to start from", add_new),
    "check": ("check programs for errors", add_check),
    "watch": ("check a program whenever it is saved, and draw it", add_watch),
    "lsp": ("serve an editor: findings, hover, completion", add_lsp),
    "fmt": ("format programs", add_fmt),
    "compile": ("compile a program, and show one of its stages", add_compile),
    "sample": ("generate annotated objects", add_sample),
    "export": ("write objects in other formats", add_export),
    "layout": ("check a folder in a layout against the model", add_layout),
    "mutate": ("make mutants of the objects in a folder", add_mutate),
    "render": ("draw a contact sheet of samples", add_render),
    "validate": ("report which links collide or block one another", add_validate),
    "report": ("measure the quality of a category over many samples", add_report),
    "ledger": ("show what determines each value of a part", add_ledger),
    "profile": ("show where the time goes, by stage and by part", add_profile),
    "fit": ("find the objects that are closest to real ones", add_fit),
    "bind": ("store the surfaces of real objects as details of the objects fitted to them", add_bind),
    "compare": ("compare samples of a category with real objects", add_compare),
    "explain": ("explain an error code", add_explain),
    "categories": ("list the shipped categories", None),
    "cache": ("show or clear the cache", add_cache),
}
"""What each command does, and what adds its options; the module of its name runs it."""
