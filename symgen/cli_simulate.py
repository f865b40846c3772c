"""symgen simulate on the command line."""

from __future__ import annotations

from pathlib import Path

import click

from symgen.cli_reading import robot_names
from symgen.terminal import print_simulation
from symgen.terminal_progress import meter, say


@click.command()
@click.argument("robot", shell_complete=robot_names)
@click.option("--parameters", required=True, help="estimate.json, or TOML with [parameters].")
@click.option("--trajectory", help="CSV with t, q1.. to follow; default a Fourier series.")
@click.option("--torque", help="CSV with t, tau1.. to play instead of a controller.")
@click.option("--hold", is_flag=True, help="Hold each of these torques until the next stamp.")
@click.option("--controller", default="computed-torque", show_default=True, help="Or pd.")
@click.option("--bandwidth", default=40.0, show_default=True, help="Of the controller, rad/s.")
@click.option("--scale", default=1.0, show_default=True, help="Its parameters over the robot's.")
@click.option("--feedback", default="true", show_default=True, help="Or measured, at stamps.")
@click.option("--encoder", default=0.0, help="Step of the encoders, rad or m.")
@click.option("--position-noise", default=0.0, help="Standard deviation of q, rad or m.")
@click.option("--velocity-noise", default=0.0, help="Of qd, rad/s or m/s.")
@click.option("--velocity-gain", default=1.0, help="Of the tachometers.")
@click.option("--no-velocity", is_flag=True, help="Leave qd out of the log.")
@click.option("--torque-noise", default=0.0, help="Of tau in the log, N m or N.")
@click.option("--torque-noise-percent", default=0.0, help="Of tau in the log, of its RMS.")
@click.option("--delay", default=0.0, help="Of q and qd behind tau in the log, s.")
@click.option("--disturbance", default=0.0, help="Torques that the log does not show, N m or N.")
@click.option("--duration", default=20.0, show_default=True, help="Of the Fourier series, s.")
@click.option("--rate", type=float, help="Of the log, Hz; default from the trajectory, or 1000.")
@click.option("--runs", default=1, show_default=True, help="Logs: LOG_1.csv and so on.")
@click.option("--seed", default=0, show_default=True, help="Of noise and Fourier series.")
@click.option("--clip", is_flag=True, help="Keep torques within [limits] instead of refusing.")
@click.option("--into", type=click.Path(path_type=Path), required=True, help="log.csv or log.npz.")
def simulate(
    robot: str,
    parameters: str,
    trajectory: str | None,
    torque: str | None,
    hold: bool,
    controller: str,
    bandwidth: float,
    scale: float,
    feedback: str,
    no_velocity: bool,
    torque_noise_percent: float,
    encoder: float,
    disturbance: float,
    duration: float,
    rate: float | None,
    runs: int,
    seed: int,
    clip: bool,
    into: Path,
    **noise: float,
) -> int:
    """Simulate ROBOT with given parameters under a controller, and write the log that it leaves."""
    import symgen
    from symgen.experiment.controller import Controller
    from symgen.experiment.instruments import Instruments
    from symgen.experiment.simulation import log_paths
    from symgen.files import check_new, write_files

    for path in log_paths(into, runs):
        check_new(path)
    given = Controller(controller, bandwidth, scale=scale, feedback=feedback)
    with meter("simulating") as advance:
        done = symgen.simulate(
            robot,
            parameters,
            trajectory=trajectory,
            torque=torque,
            hold=hold,
            controller=None if torque is not None and given == Controller() else given,
            instruments=Instruments(
                encoder_step=encoder,
                velocity=not no_velocity,
                torque_noise_relative=torque_noise_percent / 100,
                **noise,
            ),
            disturbance=disturbance,
            duration=duration,
            rate=rate,
            runs=runs,
            seed=seed,
            clip=clip,
            progress=say,
            meter=advance,
        )
    write_files(done.files(into))
    print_simulation(done)
    click.echo(f"written: {', '.join(map(str, log_paths(into, runs)))}")
    return 0
