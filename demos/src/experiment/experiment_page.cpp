#include "experiment_load.h"
#include "experiment_schema.h"

namespace bsoil::experiment {

std::string experiment_markdown() {
    return R"(# Experiments

An experiment is a TOML file that describes one rig of terramechanics, the soil it stands on, a sweep of parameters
and what the results are compared with. `bsoil plate FILE --out DIR`, `bsoil blade`, `bsoil traction`, `bsoil shear` and
`bsoil column` run one: every point of the sweep is a Bullet world of its own with a soil of its own, forces are those
that Bullet's joints feel, and the results do not depend on the number of cores.

| in DIR | |
|---|---|
| `results.csv` | a row for each point of the sweep, or for each station of a point: parameters, results, measured values and relative errors |
| `results.svg`, `results.png` | the curves with the measured points, drawn by gnuplot from `results.gnuplot` |
| `series_000.csv` ... | with `--series`: everything a point recorded, a row for each step of the soil |

`--set key=value` replaces a value of the file (keys as in a sweep, and none that is swept), `--threads N` takes fewer cores, `--no-plot` leaves
the plot out. Exit codes: 0 all expectations hold, 1 one does not, 2 could not run, 77 the sweep's points were to come
from data that is not there. A wheel or a shear head that sank as deep as its rig goes, and a heap that still moves at the
end, fail like an expectation: their rows are not what the columns say.

Every number carries its unit in its key. An unknown key, a wrong unit or a value out of range is an error with file,
line and column. This page is printed by `bsoil experiment-keys --markdown`; a test compares the two.

| experiment here | command | what stands beside it |
|---|---|---|
| `pavlov_plates.toml` | plate | plates of 60 and 100 mm in loose sand |
| `cullinan_plates.toml` | plate | a plate of 0.018 m2 in sand of three densities |
| `obermayr_blade.toml` | blade | a vertical blade at four depths |
| `pavlov_wheel_smooth.toml`, `pavlov_wheel_grousers.toml` | traction | a small wheel from locked to slip ratio 0.9 |
| `pavlov_wheel_slip_angles.toml` | traction | the same wheel at slip angles of 15, 45 and 90 deg |
| `ding_wheel.toml` | traction | a rover's wheel, smooth and with lugs |
| `second_pass.toml` | traction | a wheel that rolls three times through its own rut |
| `cullinan_shear.toml` | shear | annular shear in sand of two densities |
| `shear_sizes.toml` | shear | the same by rings of three sizes |
| `plate_unload.toml` | plate | a plate raised and pressed again |
| `blade_invariance.toml`, `wheel_invariance.toml` | blade, traction | the same tool in turned, finer and faster grids |
| `plate_invariance.toml`, `shear_invariance.toml` | plate, shear | a small plate, and a ring with grousers, in turned, finer and faster grids |
| `lug_invariance.toml`, `slip_angle_invariance.toml` | traction | a wheel with lugs, and one that rolls askew, in other grids |
| `friction_angles.toml`, `cohesions.toml`, `weights.toml` | column | columns of the thesis, [figures 45 to 47](../../docs/thesis_chapter_4.md) |

The measured data is not part of the project: without it the plate, blade and shear experiments still give their
curves, and those whose points are measured rows are skipped.

`bsoil validate` runs all of them at once, sets them beside the measurements and the classical models, and with
`--document docs/validation.md` writes that page anew: [validation](../../docs/validation.md). `--only NAME ...` takes some
of them, and leaves the page's table over all of them as it was; `--out DIR` keeps tables and pictures. Exit codes as above, 77 where no data is there at all.

## [sweep]

| key | value | meaning |
|---|---|---|
| a key of the rig's table | list | its values |
| a key of another table, as `soil.voxel_m`, `material.density_kg_m3` | list | its values; of [[material]] the first is meant |
| `row` | tables | [[sweep.row]]: explicit points, each gives the same keys |
| `from_measured` | [text, ...] | names of [[measured.column]]: each measured row is a point |

Lists, rows and measured rows are combined with each other, every one with every other: at most 100000 points. Without a
sweep the experiment is one point.

## Top level
)" + scene::table_markdown(experiment_schema());
}

}  // namespace bsoil::experiment
