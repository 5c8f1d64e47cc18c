#!/usr/bin/python3
"""calor.core: weights, residuals and Jacobians as matrices, laws in Python, against known numbers and against runs.

  core.py CALOR

Without python3-numpy and python3-scipy of Debian, and where calor.core has not been built, it ends with code 77: skipped."""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
try:
    import numpy as np
    from scipy.sparse.linalg import spsolve

    from calor import CalorError, Case, CaseError, NumbersError, Result, command
    if len(sys.argv) > 1:
        CALOR = str(pathlib.Path(sys.argv[1]).resolve())
        command.find_command = lambda: CALOR
    from calor import core
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

METHODS = ("sph", "peridynamics", "mlpg")
# A plate of points off their lattice, with k(T), air at one edge, a wall that is held, and a source.
PLATE = {
    "title": "Plate", "method": "sph",
    "cloud": {"shape": "box", "size": ["20 mm", "10 mm"], "points": [11, 6], "jitter": 0.2},
    "material": {"steel": {"conductivity": {"formula": "40 - 0.02*(T - 300)", "unit": "W/(m K)"}, "density": "7850 kg/m^3",
                           "specific_heat": {"formula": "450 + 0.3*(T - 300)", "unit": "J/(kg K)"}}},
    "initial": {"temperature": "300 K"},
    "boundary": {"hot": {"on": "xmin", "temperature": "400 K"},
                 "air": {"on": "xmax", "convection": {"h": "200 W/(m^2 K)", "ambient": "300 K"}},
                 "sky": {"on": "ymax", "radiation": {"emissivity": 0.8, "ambient": "300 K"}}},
    "source": {"current": {"power_density": {"formula": "1e6*(1 + 1e-3*(T - 300))", "unit": "W/m^3"}}},
    "time": {"end": "30 s"}, "output": {"every": "15 s"},
}
STEADY = {key: value for key, value in PLATE.items() if key not in ("time", "output", "initial")} | {"steady": {}}


class InAFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)


class Models(InAFolder):
    def models(self, case, **changes):
        return [core.Model(case, method=method, **changes) for method in METHODS]

    def test_importing_starts_neither_mpi_nor_petsc(self):
        words = "from calor import core; print(len(core.materials()) > 10)"
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "python"), "OMPI_MCA_btl": "none such"}
        said = subprocess.run([sys.executable, "-c", words], env=environment, capture_output=True, text=True)
        self.assertEqual((said.stdout, said.stderr, said.returncode), ("True\n", "", 0))

    def test_the_points_are_those_of_a_run_in_its_order(self):
        model = core.Model(PLATE)
        fields = Case(PLATE).run(show_progress=False).fields()
        np.testing.assert_array_equal(model.points, fields.x)
        np.testing.assert_allclose(model.volumes, fields["volume"], rtol=1e-6)
        self.assertEqual((len(model), model.dimension, model.points.shape, model.spacing.shape), (66, 2, (66, 3), (66, 3)))
        self.assertEqual((model.parts, set(model.part)), (["steel"], {0}))
        self.assertEqual(set(model.prescribed), set(np.flatnonzero(model.points[:, 0] < 1e-9)))

    def test_the_surface_closes_and_is_that_of_the_points(self):
        for model in self.models(PLATE):
            facets, areas = model.facets, np.zeros((len(model), 3))
            np.add.at(areas, facets.point, facets.area[:, None] * facets.normal)
            np.testing.assert_allclose(areas, model.areas, atol=1e-15)
            np.testing.assert_allclose(model.areas.sum(0), 0, atol=1e-15)
            top = facets.area[facets.face == model.faces.index("ymax")].sum()
            self.assertAlmostEqual(top, 20e-3, places=12)  # 1 m thick
            self.assertAlmostEqual(model.volumes.sum(), 2e-4, places=15)

    def test_weights_are_exact_for_linear_temperatures_and_conserve_heat(self):
        for model in self.models(PLATE):
            G, x = model.weights, model.points
            # What flows into a cell by conduction is what leaves it through the surface of the body.
            np.testing.assert_allclose((G @ x)[:, :2], -model.areas[:, :2], atol=1e-12)
            np.testing.assert_allclose(G @ np.ones(len(model)), 0, atol=1e-12)
            np.testing.assert_allclose(G.sum(0), 0, atol=1e-12)
            self.assertGreater(G.nnz, 5 * len(model))

    def test_weights_of_pairs_are_symmetric(self):
        for method in ("sph", "peridynamics"):
            G = core.Model(PLATE, method=method).weights
            self.assertEqual(abs(G - G.T).max(), 0)

    def test_shape_functions_give_temperatures_of_degrees_of_freedom(self):
        for model in self.models(PLATE):
            T = 300 + 1e4 * model.points[:, 0] ** 2
            u = model.dofs(T)
            np.testing.assert_allclose(model.shape_functions @ u, T, rtol=1e-12)
            np.testing.assert_allclose(model.temperatures(u), T, rtol=1e-12)

    def test_with_uniform_conductivity_the_rate_is_that_of_the_weights(self):
        insulated = {key: value for key, value in PLATE.items() if key not in ("boundary", "source")}
        for model in self.models(insulated, **{"material": {"steel": {"conductivity": "7 W/(m K)"}}}):
            u = np.random.default_rng(1).uniform(300, 400, len(model))
            rate = model.rate(u)
            np.testing.assert_allclose(rate, 7 * model.weights @ u, atol=1e-12 * abs(rate).max())

    def test_the_jacobian_is_the_derivative_of_the_residual(self):
        for model in self.models(PLATE):
            rng = np.random.default_rng(2)
            u, du = rng.uniform(300, 400, len(model)), rng.normal(size=len(model))
            if model.shape_functions.nnz == len(model):
                du[model.prescribed] = 0  # whose columns are left out
            known = np.zeros(len(model))
            step = 1e-3

            def difference(**factors):
                ahead, behind = (model.residual(u + s * du, 1.0, **factors) for s in (step, -step))
                return (ahead - behind) / (2 * step)
            for J, of_residual in ((model.jacobian(u, 1.0), difference()),
                                   (model.jacobian(u, 1.0, rate_factor=0.1, capacity_factor=1), difference(rate_factor=0.1, known=known))):
                np.testing.assert_allclose(J @ du, of_residual, atol=1e-6 * abs(of_residual).max())

    def test_newton_by_hand_finds_the_steady_state_of_a_run(self):
        for model in self.models(STEADY):
            u = model.start
            for _ in range(12):
                u = u - spsolve(model.jacobian(u).tocsc(), model.residual(u))
            T = model.temperatures(u)
            np.testing.assert_allclose(T, model.solve(), rtol=1e-8)
            flows = model.heat_flows(u)
            self.assertAlmostEqual(sum(flows.values()), 0, delta=1e-9 * abs(flows["hot"]))
            self.assertEqual(list(flows), ["hot", "air", "sky", "current"])
        # The last model is that of MLPG.
        run = Case(STEADY, method="mlpg").run(show_progress=False)
        np.testing.assert_allclose(run.fields()["temperature"], T, rtol=1e-8)

    def test_marching_gives_the_temperatures_of_a_run(self):
        for method in ("sph", "mlpg"):
            T = core.Model(PLATE, method=method).march([0, 15, 30])
            self.assertEqual(T.shape, (3, 66))
            fields = Case(PLATE, method=method).run(method, show_progress=False).fields(30)
            np.testing.assert_allclose(T[2], fields["temperature"], rtol=1e-9)

    def test_steps_by_hand_conserve_heat(self):
        insulated = {key: value for key, value in PLATE.items() if key not in ("boundary", "source")}
        for model in self.models(insulated):
            u, dt = model.dofs(300 + 5e3 * model.points[:, 0]), 0.5
            before = model.energy(u)
            ahead = u
            for _ in range(8):
                ahead = ahead - spsolve(model.jacobian(ahead, rate_factor=dt, capacity_factor=1).tocsc(),
                                        model.residual(ahead, rate_factor=dt, known=before))
            after = model.energy(ahead)
            self.assertAlmostEqual(after.sum(), before.sum(), delta=1e-9 * abs(before).max())
            self.assertGreater(abs(after - before).max(), 1e-3 * abs(before).max())

    def test_properties_of_the_points_are_those_of_the_case(self):
        model = core.Model(PLATE)
        T = np.linspace(300, 500, len(model))
        np.testing.assert_allclose(model.conductivity(T), 40 - 0.02 * (T - 300), rtol=1e-9)
        np.testing.assert_allclose(model.heat_capacity(T), 7850 * (450 + 0.3 * (T - 300)), rtol=1e-6)
        np.testing.assert_allclose(model.capacity(T), model.volumes * model.heat_capacity(T), rtol=1e-12)

    def test_what_does_not_fit_is_refused(self):
        model = core.Model(PLATE)
        with self.assertRaisesRegex(ValueError, "u needs 66 values, one a point"):
            model.rate(np.ones(5))
        with self.assertRaisesRegex(CaseError, "the case is transient"):
            model.solve()
        with self.assertRaisesRegex(ValueError, "ascend"):
            model.march([2, 1])
        with self.assertRaisesRegex(ValueError, "finite"):
            model.march([0, float("nan")])
        with self.assertRaises(CaseError) as wrong:
            core.Model(PLATE, {"boundary.hot.on": "left"})
        self.assertEqual((wrong.exception.code, wrong.exception.key), (3, "boundary.hot.on"))
        pathlib.Path("plate.toml").write_text('title = "Plate"\nmethod = "spf"\n')
        with self.assertRaises(CaseError) as wrong:
            core.Model("plate.toml")
        self.assertEqual((wrong.exception.file, wrong.exception.line, wrong.exception.key), ("plate.toml", 2, "method"))


class Laws(InAFolder):
    def test_a_law_of_python_is_that_of_its_formula(self):
        laws = {"material.steel.conductivity": lambda T: 40 - 0.02 * (T - 300),
                "source.current.power_density": lambda T, x: 1e6 * (1 + 1e-3 * (T - 300)) + 0 * x[:, 0]}
        for method in METHODS:
            expected = core.Model(STEADY, method=method).solve()
            np.testing.assert_allclose(core.Model(STEADY, laws, method=method).solve(), expected, rtol=1e-7)

    def test_a_law_is_named_in_the_case(self):
        case = {**STEADY, "source": {"current": {"power_density": {"callback": "heat"}}}}
        seen = []

        def heat(x, t):
            seen.append((x.shape[1], t))
            return np.full(len(x), 1e6)
        T = core.Model(case, functions={"heat": heat}).solve()
        constant = core.Model(STEADY, {"source.current.power_density": "1e6 W/m^3"}).solve()
        np.testing.assert_allclose(T, constant, rtol=1e-12)
        self.assertEqual(seen[0], (3, 0))

    def test_a_run_with_a_law_of_python_writes_its_results(self):
        result = core.run(STEADY, {"material.steel.conductivity": lambda T: 40 - 0.02 * (T - 300)}, "there")
        self.assertEqual(result.folder, pathlib.Path("there"))
        np.testing.assert_allclose(result.fields()["temperature"], core.Model(STEADY).solve(), rtol=1e-7)

    def test_a_moving_source_of_python_brings_its_heat(self):
        # A wave over the plate at 1 mm/s, 5 MW/m^3 cos^2 over 8 mm: 5e6 * 4 mm * 10 mm * 1 m = 200 W.
        def wave(x, t):
            s = x[:, 0] - 5e-3 - 1e-3 * t
            return np.where(abs(s) <= 4e-3, 5e6 * np.cos(np.pi * s / 8e-3) ** 2, 0.0)
        insulated = {key: value for key, value in PLATE.items() if key != "boundary"}
        model = core.Model(insulated, {"source.current.power_density": wave, "cloud.jitter": 0, "cloud.points": [21, 3],
                                       "material.steel.specific_heat": "450 J/(kg K)", "time.end": "8 s"})
        T = model.march([8])[0]
        came = (model.volumes * model.heat_capacity(T) * (T - 300)).sum()
        self.assertAlmostEqual(came, 200 * 8, delta=0.005 * 1600)

    def test_what_a_law_does_wrong_is_said(self):
        def solve(law):
            return core.Model(STEADY, {"material.steel.conductivity": law}).solve()
        with self.assertRaisesRegex(NumbersError, r"\(material.steel.conductivity\): the callback is nan at .*T = 35"):
            solve(lambda T: np.where(T > 350, np.nan, 40.0))
        with self.assertRaisesRegex(ValueError, "returns 2 values"):
            solve(lambda T, x: np.ones(2))
        with self.assertRaisesRegex(TypeError, "some of x, t and T, not \\(temperature\\)"):
            solve(lambda temperature: temperature)
        with self.assertRaisesRegex(ZeroDivisionError, "division"):
            solve(lambda T: 1 / 0)
        with self.assertRaises(KeyboardInterrupt):
            core.run(STEADY, {"material.steel.conductivity": lambda T: signal.raise_signal(signal.SIGINT)})
        # Ctrl-C in a run without laws of Python, as soon as it has written something: no end within a century of seconds.
        endless = {**PLATE, "time": {"end": "1e9 s", "integrator": "tr-bdf2", "step": "0.1 s"}, "output": {"samples": 1000000, "checkpoint": "0 s"}}
        hand = subprocess.Popen(["sh", "-c", f"until [ -s endless/probes.csv ] || [ -s endless/balance.csv ]; do sleep 0.02; done; kill -INT {os.getpid()}"])
        self.addCleanup(hand.kill)
        with self.assertRaises(KeyboardInterrupt):
            core.run(endless, folder="endless")
        self.assertEqual(Result("endless").numbers["interrupted_by"], signal.SIGINT)
        self.assertGreater(Result("endless").balance["time"][-1], 0)
        core.run(STEADY)  # another run goes its way
        with self.assertRaisesRegex(CaseError, "there is no callback 'k'.*the program gives q"):
            core.Model(STEADY, {"material.steel.conductivity": {"callback": "k"}}, functions={"q": lambda: 1.0})
        with self.assertRaisesRegex(CaseError, "the command has none"):
            Case(STEADY, {"material.steel.conductivity": {"callback": "k"}}).check()


class Library(unittest.TestCase):
    def test_materials_are_functions_with_sources(self):
        alumina = core.material("alumina")
        # Munro 1997 at 20 degC: 5.85 + 15360 exp(-0.04)/536.
        np.testing.assert_allclose(alumina.conductivity(293.15), 5.85 + 15360 * np.exp(-0.04) / 536, rtol=1e-4)
        self.assertEqual(alumina.specific_heat([[300, 400, 500], [600, 700, 800]]).shape, (2, 3))
        self.assertIn("Munro", alumina.sources["conductivity"])
        self.assertEqual(alumina.range, (298, 1573))
        self.assertIsNone(alumina.melting)
        self.assertEqual(core.material("water and ice").melting, (333.6e3, 272.65, 273.65))
        with self.assertRaisesRegex(CalorError, "no material 'alumnia': it has .*alumina"):
            core.material("alumnia")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
