"""JSON that is read value by value: the same values as ever, with limits."""

import json
import random

import pytest

from steadyload.layouts import readers
from steadyload.layouts.files import json_stream
from steadyload.layouts.files.json_stream import Elements, JsonText, members
from steadyload.layouts.files.record import FormatError, Record, Refused
from steadyload.layouts.readers import read_json

ITEM = {"sequence": 0, "position": [0, 0, 0], "size": [10, 10, 10], "weight": 1}
HEAD = {"format": "steadyload-layouts", "version": 1}


def layout(name, count=1):
    pallet = {"width": 100, "height": 100, "depth": 100}
    return {"name": name, "pallet": pallet, "items": [ITEM] * count}


def chunks(content, size):
    whole = content if isinstance(content, bytes) else json.dumps(content).encode()
    return [whole[k : k + size] for k in range(0, len(whole), size)]


@pytest.mark.parametrize("size", [1, 2, 3, 7, 64, 10_000])
def test_values_do_not_depend_on_where_chunks_end(size):
    value = {
        "a": [1, -2.5e10, 'é\U0001f600\\"\n', {"b": [True, None, []]}, {}],
        "n": 123456,
        "z": "",
    }
    for indent in (None, 1):
        text = JsonText(chunks(json.dumps(value, indent=indent, ensure_ascii=False).encode(), size))
        found = {k: list(v) if isinstance(v, Elements) else v for k, v in members(text, ("a",))}
        assert found == value


def test_errors_name_the_line_and_column_of_the_standard_library():
    draw, good = random.Random(1), json.dumps({**HEAD, "layouts": [layout("A")]}, indent=1)
    for _ in range(60):
        place = draw.randrange(1, len(good))
        bad = good[:place] + "\x01" + good[place + 1 :]
        with pytest.raises(json.JSONDecodeError) as theirs:
            json.loads(bad)
        with pytest.raises(FormatError) as ours:
            list(read_json(chunks(bad.encode(), 50)))
        if "is not valid JSON" in str(ours.value) and "Unterminated" not in theirs.value.msg:
            assert f"line {theirs.value.lineno}, " in str(ours.value)


def test_layouts_may_come_before_what_tells_their_format():
    content = {"layouts": [layout("A"), layout("B", 2)], **HEAD}
    assert [len(r.items) for r in read_json(chunks(content, 100))] == [1, 2]
    with pytest.raises(FormatError, match="JSON of another kind"):
        list(read_json(chunks({"layouts": [layout("A")]}, 100)))


def test_what_waits_for_its_name_has_a_limit(monkeypatch):
    monkeypatch.setattr(readers, "MAX_WAITING", 5)
    first = {"layouts": [layout("A", 3), layout("B", 3)]}
    with pytest.raises(FormatError, match="states its format and version only after"):
        list(read_json(chunks({**first, **HEAD}, 100)))
    assert len(list(read_json(chunks({**HEAD, **first}, 100)))) == 2


def test_a_layout_is_handed_out_before_the_next_is_read():
    def content():
        yield json.dumps({**HEAD, "layouts": [layout("A")]}).encode()[:-2] + b" ,"
        raise AssertionError("read too far")

    assert next(read_json(content())).name == "A"


def test_too_many_items_refuse_a_layout_and_not_the_others():
    many, one = read_json(chunks({**HEAD, "layouts": [layout("A", 5001), layout("B")]}, 10_000))
    assert isinstance(many, Refused)
    assert many.error.message == "has 5,001 items; allowed: at most 5,000"
    assert isinstance(one, Record)


def test_too_many_layouts_and_too_long_ones_are_refused(monkeypatch):
    monkeypatch.setattr(readers, "MAX_LAYOUTS", 2)
    with pytest.raises(FormatError, match="more than 2 layouts"):
        list(read_json(chunks({**HEAD, "layouts": [layout(n) for n in "ABC"]}, 100)))
    monkeypatch.setattr(json_stream, "MAX_VALUE_LENGTH", 1000)
    with pytest.raises(FormatError, match="a value of more than 1,000 characters at line 1"):
        list(read_json(chunks({**HEAD, "layouts": [layout("A", 50)]}, 100)))


def test_bytes_that_are_no_text_are_named_by_their_place():
    good = json.dumps({**HEAD, "layouts": [layout("A")]}).encode()
    for place in (1, 50, 99, 100, 101):
        bad = good[:place] + b"\xff" + good[place:]
        with pytest.raises(FormatError, match=rf"is not UTF-8 text \(byte {place}\)"):
            list(read_json(chunks(bad, 100)))


def test_many_equal_names_are_found_at_once():
    names = ",".join(f'"a{k}":0' for k in range(200_000))
    whole = f'{{"ulds":[{{{names},"a199999":1}}]}}'.encode()
    with pytest.raises(FormatError, match="states 'a199999' twice in one object"):
        list(read_json(chunks(whole, 2**18)))
