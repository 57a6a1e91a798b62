"""Parameters that do not act are detected when a contact is created."""

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


def test_a_wrong_parameter_name_is_noticed(monkeypatch):
    attach = contact_element._attach
    wrong = {"Fy": "Fyield"}
    monkeypatch.setattr(
        contact_element,
        "_attach",
        lambda tags, e, k, name: attach(tags, e, k, wrong.get(name, name)),
    )
    with pytest.raises(ContactError, match="does not act"):
        add(ContactSet())


def test_a_wrong_position_is_noticed(monkeypatch):
    attach = contact_element._attach
    monkeypatch.setattr(
        contact_element,
        "_attach",
        lambda tags, e, k, name: attach(tags, e, 1 if name == "Fy" else k, name),
    )
    with pytest.raises(ContactError, match="does not act"):
        add(ContactSet())


def test_the_short_form_that_reaches_the_normal_spring_is_noticed(monkeypatch):
    def broadcast(tags, element, position, name):
        parameter = tags.parameter()
        if name == "Fy" and position > 1:
            ops.parameter(parameter, "element", element, name)
        else:
            ops.parameter(parameter, "element", element, "material", position, name)
        return parameter

    monkeypatch.setattr(contact_element, "_attach", broadcast)
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
