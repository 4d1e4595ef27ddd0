"""The virtual servo's memory: values and bytes are one, however they were written."""

import random

import pytest

from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.frames import StatusError
from drivers.dynamixel.servo_model import ServoModel
from sim_hw.assumed import ServoAssumed
from sim_hw.dynamixel.control_table import ControlTable, measured_run

GAPS = ServoAssumed(reserved="error")


def agrees(table: ControlTable, model: ServoModel) -> None:
    for register in model.table:
        if register.name.startswith("indirect_data"):
            continue  # read through its address
        data = table.read(register.address, register.size)
        assert isinstance(data, bytes)
        assert register.decode(data) == table.get(register.name), register.name


@pytest.mark.parametrize("seed", range(3))
def test_values_are_those_of_the_bytes(seed: int) -> None:
    dice = random.Random(seed)
    table = ControlTable(MX_106, 1, 3, 0)
    registers = [one for one in MX_106.table if one.writable and one.name != "torque_enable"]
    done = 0
    for _ in range(400):
        first = dice.choice(registers)
        length = dice.choice([first.size, first.size + dice.randrange(9)])
        data = dice.randbytes(length) if dice.random() < 0.5 else bytes(length)
        if table.check_write(first.address, data) is StatusError.NONE:
            names = table.write(first.address, data)
            assert len(set(names)) == len(names) > 0
            done += 1
        agrees(table, MX_106)
        if dice.random() < 0.05:
            table.reset_ram()
            agrees(table, MX_106)
    assert done > 100


def test_a_write_through_an_indirect_address_goes_where_it_points() -> None:
    table = ControlTable(MX_106, 1, 3, 0)
    goal = MX_106.table["goal_velocity"].address
    for k in range(4):
        table.set(f"indirect_address_{1 + k}", goal + k)
    data = (-3).to_bytes(4, "little", signed=True)
    assert table.write(MX_106.table["indirect_data_1"].address, data) == ["goal_velocity"]
    assert table.get("goal_velocity") == -3
    assert table.read(MX_106.table["indirect_data_1"].address, 4) == data
    agrees(table, MX_106)


def test_a_read_across_a_gap_is_zeros_or_an_error_as_is_assumed() -> None:
    ends = {one.end for one in MX_106.table}
    begins = {one.address for one in MX_106.table}
    gap = min(ends - begins)
    assert ControlTable(MX_106, 1, 3, 0).read(gap, 1) == b"\0"
    assert ControlTable(MX_106, 1, 3, 0, GAPS).read(gap, 1) is StatusError.ACCESS


def test_only_reads_of_what_is_measured_ask_for_it() -> None:
    table = ControlTable(MX_106, 1, 3, 0)
    run = measured_run(MX_106)
    end = run.address + run.layout.size
    indirect = MX_106.table["indirect_data_1"]
    assert not table.may_show_measured(0, run.address)
    assert table.may_show_measured(run.address - 1, 2)
    assert table.may_show_measured(end - 1, 1)
    assert not table.may_show_measured(end, indirect.address - end)
    assert table.may_show_measured(indirect.address, 1), "it may point there"
