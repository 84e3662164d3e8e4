//! Pictures of extreme snapshots are finite.

use super::*;
use crate::plan::plan;
use crate::plan::scenes::extremes;

#[test]
fn extreme_snapshots_give_finite_pictures() {
    let mut executor = ReferenceExecutor::new();
    for (scene, snapshot) in extremes() {
        let plan = plan(&snapshot, &snapshot.views[0], Output::LinearRgb);
        let Pixels::LinearRgb(values) = executor.draw(&plan) else { panic!("{scene}: not linear") };
        assert_eq!(values.len() as u32, 3 * plan.size_px[0] * plan.size_px[1], "{scene}");
        let bad = values.iter().position(|v| !v.is_finite() || *v < 0.0);
        assert_eq!(bad, None, "{scene}: {:?}", bad.map(|i| values[i]));
        // By day and by night there is some light.
        assert!(values.iter().any(|v| *v > 0.0), "{scene}");
    }
}
