"""What a diagnosis answers: the verdict, the causes it names and its caveats, as values, sentences, JSON.

Made at the end of a diagnosis; read by reports, campaigns and ``gap apply``.
"""
