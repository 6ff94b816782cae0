// The suite measures how soon a large cage appears: from opening its file to the first finished tile, on a warm disk.

#include "api/include/occam/occam.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"
#include "tests/bench/wave_files.h"
#include "tests/support/temp_folder.h"

namespace occam::bench {

void run_first(Report& report)
{
    constexpr int kRuns = 3;
    const test::TempFolder folder;
    const std::filesystem::path file = folder.path() / "waves.obj";
    write_wave_obj(file, kWaveColumns, kWaveRows);

    // The cage is in the middle of the picture, so a tile of sky does not count.
    const Settings middle{
        .crop_x0 = 0.4f, .crop_x1 = 0.6f, .crop_y0 = 0.4f, .crop_y1 = 0.6f, .integrator = IntegratorKind::Direct};
    std::vector<double> load_s, first_s;
    for (int i = 0; i < kRuns; ++i) {
        const double start = wall_seconds();
        Scene scene = load(file);
        load_s.push_back(wall_seconds() - start);
        Renderer renderer;
        Job job = renderer.start(scene, Camera::framing(scene.bounds()), middle);
        while (job.progress().fraction <= 0 && !job.wait_for(std::chrono::milliseconds(1))) {
        }
        first_s.push_back(wall_seconds() - start);
        job.cancel();
        job.wait();
    }
    Row row{"first", "500,000 faces, 1280 x 720, 16 samples"};
    row.note = "wall time, file reading included";
    report.add(row.add("load_s", load_s).add("first_tile_s", first_s));
}

}  // namespace occam::bench
