"""Which of the causes that fit it is: their probabilities, and which alternatives these runs leave open.

Called when causes are found and fitted. Only what they change tells them apart, and what vibrates.
"""
