"""What to say about a syntax error. Begin with ``messages``, which asks the others in turn.

found                 an error in words
characters            what the lexer cannot read
unclosed              brackets and braces that are never closed
stop, history         where the parser stopped; what the tokens before tell
beginning             what stands where a statement begins
mistakes, examples    mistakes that people make, by example; the message for an error by these examples
accepted              what the parser would have taken
foreign               what other languages call otherwise
"""
