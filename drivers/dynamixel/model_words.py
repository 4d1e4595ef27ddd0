"""What a model number says, in words: which servo it is, and what to do when another one was expected."""

from drivers.dynamixel.catalog import MODEL_BY_NUMBER, PROTOCOL_1_NUMBERS, SERVO_MODELS
from drivers.dynamixel.servo_model import ServoModel

PAGE = "docs/servos.md"


def model_name(number: int) -> str:
    """Return the name of a model number for a person, the number itself where it is not known."""
    if number in MODEL_BY_NUMBER:
        return MODEL_BY_NUMBER[number].name
    if number in PROTOCOL_1_NUMBERS:
        return f"{PROTOCOL_1_NUMBERS[number]} with protocol 1.0 firmware"
    return f"model {number}"


def protocol_1_words(name: str) -> str:
    """Return what a servo with the old firmware lacks, and what to do.

    Args:
        name: Its name with the new firmware, empty where it is not known.
    """
    return (
        f"protocol 1.0 firmware, which has no sync read and no watchdog; put the {name} firmware on it "
        "with Dynamixel Wizard"
    )


def mismatch_words(expected: ServoModel, number: int) -> str:
    """Return what is wrong with the model of a servo and what to do, after its name; empty if nothing is.

    Args:
        expected: What the robot file says.
        number: Model number that the servo gives.
    """
    if number == expected.number:
        return ""
    if number in PROTOCOL_1_NUMBERS:
        return f"has {protocol_1_words(f'{PROTOCOL_1_NUMBERS[number]}(2.0)')}"
    if number in MODEL_BY_NUMBER:
        return (
            f"is an {MODEL_BY_NUMBER[number].name} and the robot file says {expected.name}: set model in "
            "[servo] of the robot file, unless the id is that of another leg"
        )
    return unknown_words(number)


def unknown_words(number: int) -> str:
    """Return what to do about a model number that nobody here knows, after the servo's name."""
    known = ", ".join(model.name for model in SERVO_MODELS)
    return (
        f"is model {number}, which is not known here; check that the id is not that of another servo. "
        f"Known are {known}; how to add one: {PAGE}"
    )
