//! Tables 1, 2 and 3 of the lightning paper: time and grown cells, beside what it printed.

use super::super::result::Case;
use super::super::subject::{Run, Stopped};
use super::{bolts, plane, spread};
use crate::lightning::grid::Grid;
use crate::lightning::grow::Method;
use crate::lightning::laplacian::DEFAULT_PULL;
use crate::lightning::scene::Scene;

/// What the paper printed for one method: milliseconds and cells.
type Printed = Option<(f64, u32)>;

/// One row of table 1 or 2.
struct Row {
    grid: Grid,
    /// eta of exact breakdown; eta of the rational potential at rho 3.
    etas: [f64; 2],
    printed: [Printed; 2],
    /// Seeds of the fast methods, and of conjugate gradients (0: too slow).
    seeds: [u64; 2],
}

/// Tables 1 (planes) and 2 (volumes).
pub(super) fn target_scenes(run: &mut Run) -> Result<(), Stopped> {
    let cube = |side| Grid::volume(side, side, side);
    let row = |grid, etas, dbm, rational, seeds| Row { grid, etas, printed: [Some(dbm), Some(rational)], seeds };
    let mut rows = vec![
        row(plane(32)?, [2.0, 2.0], (26.0, 52), (2.0, 56), [20, 5]),
        row(plane(64)?, [2.0, 2.0], (199.0, 136), (13.0, 175), [20, run.pick(0, 5)]),
        row(cube(32)?, [3.0, 2.0], (3720.0, 76), (27.0, 75), [20, 0]),
    ];
    if !run.quick() {
        rows.push(row(plane(128)?, [2.0, 3.0], (1429.0, 395), (60.0, 371), [20, 3]));
        rows.push(row(plane(256)?, [2.0, 3.0], (18555.0, 1262), (713.0, 1347), [9, 0]));
        rows.push(row(cube(64)?, [3.0, 2.0], (104_918.0, 280), (204.0, 313), [20, 0]));
    }
    for row in rows {
        let size = row.grid.size().map(|side| side.to_string());
        let name = format!("table {}: {}", row.grid.axes() - 1, size[..row.grid.axes()].join(" x "));
        let scene = Scene::top_to_bottom(row.grid);
        let [seeds, slow_seeds] = row.seeds;
        let [exact_eta, rational_eta] = row.etas;
        let mut methods = vec![
            (Method::Dielectric { eta: exact_eta }, seeds, row.printed[0]),
            (Method::rational(rational_eta, 3.0), seeds, row.printed[1]),
            (Method::laplacian(3.0, DEFAULT_PULL), seeds, None),
        ];
        if slow_seeds > 0 {
            for tolerance in [1e-6, 1e-3, 1e-1] {
                let printed = row.printed[0].filter(|_| tolerance == 1e-6);
                methods.push((Method::DielectricConjugate { eta: exact_eta, tolerance }, slow_seeds, printed));
            }
        }
        let mut of_exact = None;
        for (method, seeds, printed) in methods {
            let grown = bolts(&method, &scene, 100_000, seeds)?;
            let (mean, deviation) = spread(&grown.cells);
            // Exact breakdown stands first.
            let (exact, exact_s) = *of_exact.get_or_insert((mean, grown.time_s.median));
            let mut case = Case::new(&name, method.name())
                .time(grown.time_s)
                .note(format!("{mean:.0} +- {deviation:.0} cells over {seeds} seeds"));
            case = parameters(case, &method);
            if matches!(method, Method::DielectricConjugate { .. }) {
                let solves: f64 = grown.cells.iter().sum();
                let iterations: u64 = grown.all.iter().map(|(_, info)| info.iterations).sum();
                case = case.note(format!(
                    "{:.1} iterations a solve; {:.0} times the median time of the exact form in this run",
                    iterations as f64 / solves,
                    grown.time_s.median / exact_s
                ));
            }
            if let Some((ms, cells)) = printed {
                case = case.note(format!("the paper printed {ms} ms and {cells} cells"));
            }
            let error = (mean / exact - 1.0).abs();
            run.record(case.error(
                "share by which the mean count of cells is off",
                "exact dielectric breakdown",
                error,
            ))?;
        }
    }
    Ok(())
}

/// Table 3: time against cells on 512 x 512 with eta 2; the channel starts in the middle and has no target.
pub(super) fn free_growth(run: &mut Run) -> Result<(), Stopped> {
    let scene = Scene::free(plane(512)?);
    // Cells, and the paper's milliseconds for fast Laplacian growth and the rational potential.
    let rows = [
        (100, [10.0, 8.0]),
        (500, [72.0, 35.0]),
        (1000, [181.0, 94.0]),
        (2000, [496.0, 288.0]),
        (5000, [2022.0, 1319.0]),
    ];
    for (cells, printed) in rows.into_iter().take(run.pick(3, 5)) {
        let fast = [Method::laplacian(2.0, DEFAULT_PULL), Method::rational(2.0, 3.0)];
        for (method, ms) in fast.iter().zip(printed) {
            let grown = bolts(method, &scene, cells, run.pick(3, 9))?;
            let case = Case::new(format!("table 3: {cells} cells"), method.name()).time(grown.time_s);
            run.record(parameters(case, method).note(format!("the paper printed {ms} ms")))?;
        }
        if cells <= run.pick(100, 500) {
            let method = Method::Dielectric { eta: 2.0 };
            let grown = bolts(&method, &scene, cells, 3)?;
            let case = Case::new(format!("table 3: {cells} cells"), method.name()).time(grown.time_s);
            run.record(parameters(case, &method).note("exact; the table of the Green's function is kept"))?;
        }
    }
    Ok(())
}

/// With the method's parameters.
pub(super) fn parameters(case: Case, method: &Method) -> Case {
    match *method {
        Method::ReedWyvill(_) => case,
        Method::Dielectric { eta } => case.param("eta", eta),
        Method::DielectricConjugate { eta, tolerance } => case.param("eta", eta).param("tolerance", tolerance),
        Method::Laplacian { eta, pull, .. } => case.param("eta", eta).param("pull", pull),
        Method::Rational { eta, rho, .. } => case.param("eta", eta).param("rho", rho),
    }
}
