"""Add contact and friction to two existing models, a frame and a tower.

Run it in this folder: python contact_in_your_model.py
"""

import sys

from foreign_models import portal_frame, tower

from skewbridge.contact import ContactSet, UnitLedger, make_step


def analyse_with_stop(node: int, fixed_node: int, normal: tuple[float, ...]) -> UnitLedger:
    """Add a stop 5 mm from a node of the current model, run 4 s and return the contact ledger."""
    stops = ContactSet()
    stops.add(fixed_node, node, normal, 0.005, 0.4, kn=1e5, kt=1e5)  # here in kN and m
    for _ in range(2000):
        if not make_step(stops, 0.002):  # instead of ops.analyze(1, 0.002)
            sys.exit("no convergence")
    return stops.ledger()[0]


def main() -> list[UnitLedger]:
    """Return the ledgers of two skew stops, one at the frame and one at the tower."""
    portal_frame()
    ledgers = [analyse_with_stop(4, 9, (-0.8, 0.6))]
    tower()
    return [*ledgers, analyse_with_stop(2, 9, (-0.8, 0.6, 0.0))]


if __name__ == "__main__":
    for ledger in main():
        sys.stdout.write(f"{ledger}\n")
