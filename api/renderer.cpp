#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "api/renderer_state.h"
#include "base/default_floats.h"
#include "base/error_without_file.h"
#include "base/freed_memory.h"
#include "base/stopwatch.h"
#include "render/cryptomatte.h"
#include "render/frame.h"
#include "render/metadata.h"
#include "render/replay.h"
#include "scenegraph/content_rules.h"
#include "shade/input_limits.h"

namespace occam {
namespace {

constexpr std::size_t kMostFreedBytes = std::size_t(64) << 20;  ///< a process may keep these beside what a frame took

FrameStats::Scene describe(const Scene& scene)
{
    FrameStats::Scene out;
    const Scene::Counts counts = scene.counts();
    out.nodes = counts.nodes;
    out.cages = counts.cages;
    out.faces = counts.faces;
    out.lights = counts.lights;
    out.warnings = scene.warnings.size();
    out.triangles_in = counts.mesh_triangles;
    return out;
}

/// Throws Error if one of these cannot make a picture.
void check_inputs(const Scene& scene, const Camera& camera, const Settings& settings)
{
    render::check(settings);
    check(scene.environment);
    if (scene.environment.image && !scene.find(scene.environment.image))
        throw error_without_file("the image must be a texture of the scene that was not removed", "environment");
    check(camera);
    if (settings.lod_camera) check(*settings.lod_camera);
}

/// Returns what a frame ends with for which there is not enough memory. If there is none for a message either, that is the
/// std::bad_alloc which is being handled.
std::exception_ptr error_for_lack_of_memory() noexcept
{
    try {
        return std::make_exception_ptr(
            error_without_file("there is not enough memory for this picture", {}, Error::Kind::Output));
    } catch (const std::bad_alloc&) {
        return std::current_exception();
    }
}

/// Makes a renderer busy. Throws Error if it is that already.
void take(std::atomic<bool>& busy)
{
    if (busy.exchange(true)) throw error_without_file("this renderer is busy with another frame");
}

/// Keeps a renderer busy for a scope.
class Turn {
public:
    explicit Turn(std::atomic<bool>& busy) : busy_(busy) { take(busy); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn() { busy_ = false; }

private:
    std::atomic<bool>& busy_;
};

// g++ 12 takes the same as one expression for a read beyond the end of a string (its bug 105651).
std::string few_samples_for_mitchell(int enough)
{
    std::string line = "the filter mitchell has negative weights: with fewer than ";
    line += std::to_string(enough);
    line += " samples some pixels may stay black";
    return line;
}

}  // namespace

struct Job::State {
    State(std::shared_ptr<Renderer::State> borrowed_renderer, Scene& borrowed_scene, const Camera& with_camera,
          const Settings& with_settings)
        : renderer(std::move(borrowed_renderer)), scene(borrowed_scene), camera(with_camera), settings(with_settings)
    {
    }
    ~State()
    {
        control.cancel();
        if (thread.joinable()) thread.join();
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    /// Locks the scene for the frame. The caller's DefaultFloats are open.
    void begin()
    {
        scene.refit();
        bounds = scene.bounds();
        memory = render::plan_memory(scene, renderer->resources);
        stats.seconds.refit = seconds_since(start);
        lock = std::make_unique<Scene::FrameLock>(scene);
    }

    /// Makes the frame in a thread of its own. Where the system gives none, a caller who would wait makes it.
    void launch(bool caller_waits)
    {
        try {
            thread = std::thread([this] { run(); });
        } catch (const std::system_error& refusal) {
            if (!caller_waits)
                throw error_without_file("the system gives no thread for the frame: " + refusal.code().message(), {},
                                         Error::Kind::Output);
            run();
        }
    }

    void run() noexcept
    {
        const DefaultFloats floats;
        try {
            make_image();
        } catch (const std::bad_alloc&) {
            error = error_for_lack_of_memory();
        } catch (...) {
            error = std::current_exception();
        }
        if (error) renderer->lights = {};  // it may be made from images that could not be decoded
        if (error && !renderer->textures.has_failed()) checkpoint.clear();
        // What a frame takes stays with the process, so that the next one need not ask the system for it again.
        return_freed_memory(stats.memory.arena_peak_bytes + kMostFreedBytes);
        tables.reset();
        lock.reset();
        renderer->busy = false;
        control.enter(Stage::Done);
        const std::lock_guard guard(mutex);
        done = true;
        ended.notify_all();
    }

    void prepare()
    {
        control.enter(Stage::Preparing);
        const auto prepare_start = Clock::now();
        tables.emplace(renderer->topologies, scene);
        renderer->textures.prepare(scene);
        refuse_flaws();
        stats.seconds.texture = seconds_since(prepare_start) - renderer->textures.decode_seconds();
    }

    render::FrameInputs inputs(Clock::time_point deadline) const
    {
        return {scene,
                bounds,
                camera,
                settings,
                renderer->resources,
                memory,
                tables->cache(),
                renderer->textures,
                renderer->lights,
                deadline,
                keeps_checkpoint,
                resumed};
    }

    void make_image()
    {
        prepare();
        const auto deadline = settings.deadline_s > 0 ? start + std::chrono::duration_cast<Clock::duration>(
                                                                    std::chrono::duration<double>(settings.deadline_s))
                                                      : Clock::time_point::max();
        auto result = render::render_frame(inputs(deadline), control, stats);
        image = std::move(result.image);
        checkpoint = std::move(result.checkpoint);
        settings.clamp = result.clamp;  // from here on it is that of the picture as it was made
        settings.clamp_as_shown = false;
        resumed = {};
        refuse_flaws();  // of texels that turned out to be unreadable, and of cages that were made
        render::describe(image, camera, settings, stats);
        render::describe_mattes(image, scene, settings);
        finish_stats();
    }

    /// Lists what is amiss with textures and with cages on demand, as far as it is known by now.
    std::vector<std::string> flaws_of_contents() const
    {
        std::vector<std::string> lines = renderer->textures.warnings();
        for (std::string& line : tables->cache().repairs(scene)) lines.push_back(std::move(line));
        return lines;
    }

    void refuse_flaws() const
    {
        std::vector<std::string> lines = renderer->textures.errors();
        if (settings.strict)
            for (std::string& line : flaws_of_contents()) lines.push_back(std::move(line));
        if (lines.empty()) return;
        const std::string more = lines.size() > 1 ? "and " + std::to_string(lines.size() - 1) + " more such lines" : "";
        throw error_without_file(lines.front(), more);
    }

    void finish_stats()
    {
        stats.scene = describe(scene);
        stats.motion = {scene.shutter_segments(), camera.keys.empty() ? 0 : int(camera.keys.size()) - 1};
        stats.settings = settings;
        stats.threads = renderer->resources.threads;
        stats.seconds.total = seconds_since(start);
        stats.rays.per_second = double(stats.rays.total()) / stats.seconds.total;
        stats.memory.peak_bytes = render::process_peak_bytes();
        stats.seconds.texture += renderer->textures.decode_seconds();
        stats.memory.texture_bytes = renderer->textures.bytes();
        stats.image.width = image.width, stats.image.height = image.height;
        stats.image.spp = settings.spp;
        // Who stops a frame does not want to wait, and a part of a picture is compared with nothing.
        if (!control.is_cancelled()) stats.image.checksum = image.checksum();
        stats.warnings.clear();
        if (!stats.complete && !control.is_cancelled())
            stats.warnings.push_back(stats.image.least_samples > 0
                                         ? "out of time: the picture has " + std::to_string(stats.image.least_samples) +
                                               " of " + std::to_string(settings.spp) + " samples a pixel"
                                         : std::string("out of time: some pixels have no sample and are black"));
        constexpr int kEnoughOfEitherSign = 16;
        if (settings.filter == render::FilterKind::Mitchell && settings.jitter && settings.spp < kEnoughOfEitherSign)
            stats.warnings.push_back(few_samples_for_mitchell(kEnoughOfEitherSign));
        const auto add = [&](const std::vector<std::string>& lines) {
            stats.warnings.insert(stats.warnings.end(), lines.begin(), lines.end());
        };
        add(scene.warnings);
        add(shade::input_warnings(scene, renderer->textures, settings.sky_strength, FrameScale(bounds)));
        add(flaws_of_contents());
        stats.scene.warnings = stats.warnings.size();
    }

    void wait_until_done()
    {
        std::unique_lock guard(mutex);
        ended.wait(guard, [&] { return done; });
    }
    void wait_and_throw()
    {
        wait_until_done();
        if (error) std::rethrow_exception(error);
    }

    std::shared_ptr<Renderer::State> renderer;
    Scene& scene;
    Camera camera;
    Settings settings;
    Box3d bounds;
    render::MemoryPlan memory;
    Clock::time_point start = Clock::now();
    std::unique_ptr<Scene::FrameLock> lock;
    std::optional<TopologyUse> tables;  ///< from prepare() to the end of the frame
    render::FrameControl control;

    bool keeps_checkpoint = true;
    std::string resumed;  ///< the checkpoint that the frame goes on from; empty while there is none
    Image image;
    std::string checkpoint;  ///< empty unless the frame is unfinished, or failed because of a texture
    FrameStats stats;
    std::exception_ptr error;

    std::mutex mutex;
    std::condition_variable ended;
    bool done = false;
    std::thread thread;
};

Job::Job(std::unique_ptr<State> state) : state_(std::move(state)) {}
Job::Job(Job&&) noexcept = default;
Job& Job::operator=(Job&&) noexcept = default;
Job::~Job() = default;

bool Job::wait_for(std::chrono::milliseconds time) const
{
    // The clock cannot count to the end of the longest time.
    const auto most = std::clamp<std::chrono::milliseconds>(time, std::chrono::hours(0), std::chrono::hours(24 * 365));
    std::unique_lock guard(state_->mutex);
    return state_->ended.wait_for(guard, most, [&] { return state_->done; });
}

void Job::wait() const { state_->wait_until_done(); }
Progress Job::progress() const noexcept { return state_->control.progress(); }
void Job::cancel() noexcept { state_->control.cancel(); }

const Image& Job::image() const
{
    state_->wait_and_throw();
    return state_->image;
}

Image Job::take_image()
{
    state_->wait_and_throw();
    return std::exchange(state_->image, {});
}

const std::string& Job::checkpoint() const
{
    state_->wait_until_done();
    if (state_->checkpoint.empty()) state_->wait_and_throw();
    return state_->checkpoint;
}

const FrameStats& Job::stats() const
{
    state_->wait_and_throw();
    return state_->stats;
}

Renderer::Renderer(const Resources& resources) : state_(std::make_shared<State>(resources)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Job Renderer::start(Scene& scene, const Camera& camera, const Settings& settings, std::string checkpoint)
{
    return start(scene, camera, settings, std::move(checkpoint), false);
}

Job Renderer::start(Scene& scene, const Camera& camera, const Settings& settings, std::string checkpoint, bool caller_waits)
{
    const DefaultFloats floats;
    check_inputs(scene, camera, settings);
    take(state_->busy);
    try {
        auto job = std::make_unique<Job::State>(state_, scene, camera, settings);
        job->resumed = std::move(checkpoint);
        job->keeps_checkpoint = !caller_waits;
        job->begin();
        job->launch(caller_waits);
        return Job(std::move(job));
    } catch (...) {
        state_->busy = false;
        throw;
    }
}

Image Renderer::render(Scene& scene, const Camera& camera, const Settings& settings)
{
    Job job = start(scene, camera, settings, {}, true);
    {
        const std::lock_guard guard(state_->stats_mutex);  // another thread may have begun and ended its frame since
        state_->stats = job.stats();
    }
    return job.take_image();
}

SampleColor Renderer::replay(Scene& scene, const Camera& camera, const Settings& settings, const PixelSample& which,
                             std::ostream& out)
{
    const DefaultFloats floats;
    check_inputs(scene, camera, settings);
    const Turn turn(state_->busy);
    Job::State frame(state_, scene, camera, settings);
    try {
        frame.begin();
        frame.prepare();
        const render::SampleResult result = render::replay_sample(frame.inputs(Clock::time_point::max()),
                                                                  {which.x, which.y, which.sample}, out);
        frame.refuse_flaws();  // of texels that turned out to be unreadable, and of cages that were made
        return {result.radiance, result.alpha};
    } catch (...) {
        state_->lights = {};  // it may be made from images that could not be decoded
        throw;
    }
}

std::size_t Renderer::memory_floor(const Scene& scene) const
{
    const DefaultFloats floats;
    Resources resources = state_->resources;
    resources.memory_bytes = ~std::size_t(0);
    return render::plan_memory(scene, resources).floor_bytes;
}

std::uint64_t Renderer::halvings(const Scene& scene)
{
    const DefaultFloats floats;
    const Turn turn(state_->busy);
    state_->textures.prepare(scene);
    return state_->textures.halvings_hash();
}

const FrameStats& Renderer::stats() const noexcept { return state_->stats; }

}  // namespace occam
