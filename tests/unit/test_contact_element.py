"""Parameters that do not act are detected when a contact is created."""

from functools import partial

import openseespy.opensees as ops
import pytest

from skewbridge.contact import ContactError, ContactSet, TagSource
from skewbridge.contact import element as contact_element


@pytest.fixture(autouse=True)
def domain():
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    for node in (1, 2):
        ops.node(node, 0.0, 0.0, 0.0)
    yield
    ops.wipe()


def add(contacts):
    return contacts.add(1, 2, (1.0, 0.0, 0.0), 0.05, 0.5, kn=2e9, kt=2e8)


@pytest.mark.parametrize("scheme", ["vector", "componentwise", "elastic"])
def test_a_unit_is_proved_and_leaves_nothing_behind(scheme):
    contacts = ContactSet(scheme=scheme)
    add(contacts)
    assert ops.getEleTags() == [1] or ops.getEleTags() == 1
    assert len(ops.getParamTags()) == 5
    assert all(ops.getParamValue(bound) == 0.0 for bound in contacts.units[0].springs.bounds)


def wrong_name(attach, tags, element, position, name):
    return attach(tags, element, position, {"Fy": "Fyield"}.get(name, name))


def wrong_position(attach, tags, element, position, name):
    return attach(tags, element, 1 if name == "Fy" else position, name)


def without_position(attach, tags, element, position, name):
    """The short form of OpenSees, which reaches the normal spring, too."""
    if name != "Fy" or position == 1:
        return attach(tags, element, position, name)
    parameter = tags.parameter()
    ops.parameter(parameter, "element", element, name)
    return parameter


@pytest.mark.parametrize("wrong", [wrong_name, wrong_position, without_position])
def test_a_parameter_that_does_not_act_is_noticed(monkeypatch, wrong):
    monkeypatch.setattr(contact_element, "_attach", partial(wrong, contact_element._attach))
    with pytest.raises(ContactError, match="does not act"):
        add(ContactSet())


def test_tags_of_the_user_are_left_alone():
    ops.uniaxialMaterial("Elastic", 7, 1.0)
    ops.element("zeroLength", 40, 1, 2, "-mat", 7, "-dir", 1)
    ops.parameter(12, "element", 40, "material", 1, "E")
    contacts = ContactSet(TagSource())
    add(contacts)
    assert contacts.units[0].element > 40
    assert min(contacts.units[0].springs.bounds) > 12


def test_own_tags_are_used():
    class Counter:
        def __init__(self):
            self.given = 5000

        def free(self):
            self.given += 1
            return self.given

        node = element = material = parameter = free

    contacts = ContactSet(Counter())
    add(contacts)
    assert contacts.units[0].element > 5000
