"""Tables and folded parts of a diagnosis' page."""

import html
import re
from collections.abc import Sequence

Rows = Sequence[Sequence[str]]


class Raw(str):
    """HTML that is put into a table as it is."""

    __slots__ = ()


def folded(title: str, content: str) -> str:
    """Return content that opens at a click; nothing if there is none."""
    if not content:
        return ""
    return f"<details><summary>{html.escape(title)}</summary>\n{content}</details>"


def table(head: Sequence[str], rows: Rows) -> str:
    """Return a table; nothing without rows."""
    if not rows:
        return ""
    top = "".join(f"<th scope='col'>{html.escape(one)}</th>" for one in head)
    body = "\n".join(
        "<tr>" + "".join(f"<td>{_cell(text)}</td>" for text in row) + "</tr>" for row in rows
    )
    return f"<div class='wide'><table><thead><tr>{top}</tr></thead>\n<tbody>{body}</tbody></table></div>"


def note(text: str) -> str:
    """Return a line in small letters; nothing without text."""
    return f"<p class='small'>{html.escape(text)}</p>" if text else ""


def command(name: str, text: str) -> Raw:
    """Return what to do with its command line, which breaks between its words only: no option is torn."""
    words = " ".join(f"<span>{html.escape(word)}</span>" for word in text.split())
    below = f"<br><code class='command'>{words}</code>" if words else ""
    return Raw(html.escape(name) + below)


def with_sign(text: str) -> str:
    """Write +- as one sign, on one line with its numbers."""
    return text.replace(" +- ", "\xa0±\xa0").replace("+-", "±")


def _cell(text: str) -> str:
    """A name may break behind an underscore or the dot of a file, and nowhere else."""
    if isinstance(text, Raw):
        return text
    words = html.escape(with_sign(text))
    return re.sub(r"([_/]|\.(?=[a-z]))", r"\1<wbr>", words)
