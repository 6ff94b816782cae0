// A game's loop: the application owns the scene, and every frame is new.
//
//     occam_game [FILE.glb ...] [--headless] [--frames N] [--size WxH] [-o PICTURE]
//
// Each FILE holds a character whose first clip is played, in place of the worm. The key Escape ends the game. Without a
// window, the last frame is written to PICTURE (game.png).
#include <occam/occam.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "arguments.h"
#include "failure.h"
#include "game.h"
#ifdef OCCAM_HAS_SDL2
#include <SDL2/SDL.h>
#endif

using namespace occam;
using sample::Game;

namespace {

int play_headless(Game& game, Settings settings, int frames, const std::filesystem::path& picture)
{
    Image::check_writable(picture);
    Renderer renderer;
    for (int frame = 0; frame < frames; ++frame) {
        const double clock = frame / 30.0;
        game.step(clock);
        const Image image = renderer.render(game.scene(), game.camera(clock), settings);
        std::printf("frame %d: %.3f s, %llu vertices deformed, checksum %016llx\n", frame, renderer.stats().seconds.total,
                    static_cast<unsigned long long>(renderer.stats().built.vertices_deformed),
                    static_cast<unsigned long long>(image.checksum()));
        if (frame + 1 == frames) image.write(picture);
    }
    return 0;
}

#ifdef OCCAM_HAS_SDL2
unsigned display_value(float linear)
{
    const float v = linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
    return static_cast<unsigned>(std::lround(255 * std::fmin(std::fmax(v, 0.0f), 1.0f)));
}

int play(Game& game, Settings settings)
{
    if (SDL_Init(SDL_INIT_VIDEO) != 0) throw Error("", SDL_GetError(), "window");
    SDL_Window* window = SDL_CreateWindow("Occam", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, settings.width,
                                          settings.height, 0);
    SDL_Surface* surface = window ? SDL_GetWindowSurface(window) : nullptr;
    if (!surface) throw Error("", SDL_GetError(), "window");
    Renderer renderer;
    const Uint32 start = SDL_GetTicks();
    for (bool open = true; open;) {
        for (SDL_Event event; SDL_PollEvent(&event);)
            open &= event.type != SDL_QUIT && !(event.type == SDL_KEYDOWN && event.key.keysym.sym == SDLK_ESCAPE);
        const double clock = (SDL_GetTicks() - start) / 1000.0;
        game.step(clock);
        const Image image = renderer.render(game.scene(), game.camera(clock), settings);
        const std::vector<float>& rgba = image.layers().front().pixels;
        for (int y = 0; y < image.height; ++y) {
            auto* row = reinterpret_cast<Uint32*>(static_cast<char*>(surface->pixels) + y * surface->pitch);
            for (int x = 0; x < image.width; ++x) {
                const float* p = &rgba[4 * static_cast<std::size_t>(y * image.width + x)];
                row[x] = SDL_MapRGB(surface->format, Uint8(display_value(p[0])), Uint8(display_value(p[1])),
                                    Uint8(display_value(p[2])));
            }
        }
        SDL_UpdateWindowSurface(window);
    }
    SDL_DestroyWindow(window);
    SDL_Quit();
    return 0;
}
#endif

// Holds the options of the command line.
struct Words {
    std::vector<std::filesystem::path> files;
    bool headless = false;
    std::string only_headless;  ///< the last option that is for --headless alone
    int frames = 100, width = 640, height = 360, spp = 4;
    std::filesystem::path picture = "game.png";

    /// Reads the command line. Returns false if help was asked for, which is then printed. Throws Error for an unknown
    /// option, and for one that does nothing in a window.
    bool read(int argc, char** argv)
    {
        if (sample::Arguments(argc, argv)
                .wants_help("occam_game [FILE.glb ...] [--headless] [--frames N] [--size WxH] [-o PICTURE]"))
            return false;
        for (int i = 1; i < argc; ++i) {
            const std::string word = argv[i];
            const char* value = i + 1 < argc ? argv[i + 1] : "";
            int end = 0;
            if (word == "--headless") headless = true;
            else if (word == "--frames" && std::sscanf(value, "%d%n", &frames, &end) == 1 && !value[end] && frames > 0)
                ++i, only_headless = word;
            else if (word == "--size" && std::sscanf(value, "%dx%d%n", &width, &height, &end) == 2 && !value[end]) ++i;
            else if (word == "-o" && *value) picture = argv[++i], only_headless = word;
            else if (word[0] != '-') files.emplace_back(word);
            else throw Error("", "is not understood here (--help)", word + (*value ? std::string(" ") + value : ""));
        }
#ifdef OCCAM_HAS_SDL2
        if (!headless && !only_headless.empty())
            throw Error("", "would do nothing without --headless: a window stays until it is closed (--help)",
                        only_headless);
#endif
        return true;
    }
};

}  // namespace

int main(int argc, char** argv)
try {
    Words words;
    if (!words.read(argc, argv)) return 0;
    Game game(words.files);
    const Settings settings{.width = words.width,
                            .height = words.height,
                            .spp = words.spp,
                            .integrator = IntegratorKind::Direct,
                            .shading_rate = 2};
#ifdef OCCAM_HAS_SDL2
    if (!words.headless) return play(game, settings);
#else
    if (!words.headless) std::puts("built without SDL2: no window");
#endif
    return play_headless(game, settings, words.frames, words.picture);
} catch (...) {
    return sample::exit_code_of_failure("occam_game");
}
