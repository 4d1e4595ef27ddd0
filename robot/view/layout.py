"""A layout for Foxglove: the robot, its path, velocities, forces, modes and faults on one screen."""

from foxglove.layouts import (
    BasePanel,
    BaseRendererSceneUpdateTopicSettings,
    Layout,
    LogConfig,
    LogPanel,
    PlotConfig,
    PlotPanel,
    PlotSeries,
    SplitContainer,
    SplitItem,
    StateTransitionsConfig,
    StateTransitionsPanel,
    StateTransitionsSeries,
    ThreeDeeConfig,
    ThreeDeePanel,
)

from model.values.machine_names import MachineNames
from robot.view.foxglove import NEWS_TOPIC, SCENE_TOPIC, TRAJECTORY_TOPIC
from robot.view.frames import BODY_FRAME


def layout_text(names: MachineNames) -> str:
    """Return the layout as JSON, for the import of layouts.

    Args:
        names: Names of joints and legs.
    """
    scene = ThreeDeePanel(
        title="Robot",
        config=ThreeDeeConfig(
            follow_tf=BODY_FRAME,
            topics={
                topic: BaseRendererSceneUpdateTopicSettings(visible=True)
                for topic in (SCENE_TOPIC, TRAJECTORY_TOPIC)
            },
        ),
    )
    texts = ("/state.mode", "/state.stop_reason", "/estimate.health")
    states = StateTransitionsPanel(
        title="Modes and health",
        config=StateTransitionsConfig(paths=[StateTransitionsSeries(value=path) for path in texts]),
    )
    news = LogPanel(title="Faults", config=LogConfig(topic_to_render=NEWS_TOPIC))
    left = _column((scene, 3.0), (states, 1.0), (news, 1.0))
    velocity = _plot("Forward velocity [m/s]", [
        f"/velocity.{who}.vx_m_s" for who in ("true", "predicted", "estimated")
    ])  # fmt: skip
    difference = _plot("Predicted - true [m/s]", [
        "/velocity.difference.vx_m_s", "/velocity.difference.vy_m_s",
    ])  # fmt: skip
    loads = _plot("Vertical foot forces, predicted - measured [N]", [
        f"/force/{name}.difference.z_n" for name in names.legs
    ])  # fmt: skip
    first = _plot(f"Vertical force of {names.legs[0]} [N]", [
        f"/force/{names.legs[0]}.measured.z_n", f"/force/{names.legs[0]}.predicted.z_n",
    ])  # fmt: skip
    health = _plot("Hottest is what counts [degrees C]", [
        f"/servo/{name}.temperature_c" for name in names.joints
    ])  # fmt: skip
    right = _column((velocity, 1.0), (difference, 1.0), (first, 1.0), (loads, 1.0), (health, 1.0))
    content = SplitContainer(
        direction="row",
        items=[SplitItem(content=left, proportion=1.0), SplitItem(content=right, proportion=1.0)],
    )
    text: str = Layout(content=content).to_json()
    return text


def _column(*panels: tuple[BasePanel, float]) -> SplitContainer:
    return SplitContainer(
        direction="column",
        items=[SplitItem(content=panel, proportion=share) for panel, share in panels],
    )


def _plot(title: str, paths: list[str]) -> PlotPanel:
    series = [PlotSeries(value=path, enabled=True) for path in paths]
    return PlotPanel(title=title, config=PlotConfig(paths=series))
