"""The language server: what is wrong with a program, what a word in it stands for and what may follow, told to an editor as one types.

In: texts as an editor has them, saved or not. Out: findings, and for a place in a text what is there, by the rules of the
checker and the tables of the language; answers are data of our own until ``server`` puts them into the words of the Language
Server Protocol. Begin with ``analysis``.

    analysis      one text: its findings, its names and types; of a text with mistakes, those of the rest
    lookup        the name at a place: what it stands for, and where that is declared
    uses          where what it stands for is used
    rename        the edits that give it another name
    completion    what may be written at a place
    outline       what a file declares, and what these declare
    colours       which words are keywords, types, parts, functions, numbers
    fixes         the edits that findings propose
    documents     the documents that an editor has open, of its protocol: threads and columns
    server        the protocol: what is asked, and answered
"""
