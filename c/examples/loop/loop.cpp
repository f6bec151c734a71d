// A robot driver's loop with Hierarq in it: 1 kHz, without allocation. The robot is an integrator of its velocities; a driver reads encoders and
// commands velocities in its place.
//
//     hierarq compile reach.hq --format json > reach.json
//     loop reach.json [seconds] [--as-fast-as-possible]

#include <hierarq.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace {

struct Free {
    void operator()(hierarq_program *program) const { hierarq_program_free(program); }
    void operator()(hierarq_controller *controller) const { hierarq_controller_free(controller); }
};

int failed(const char *what, const char *why) {
    std::fprintf(stderr, "%s: %s\n", what, why);
    return 1;
}

}  // namespace

int main(int argc, char **argv) {
    if (argc < 2) return failed("usage", "loop PROGRAM.json [SECONDS] [--as-fast-as-possible]");
    std::ifstream file(argv[1], std::ios::binary);
    const std::string json{std::istreambuf_iterator<char>(file), {}};
    const double seconds = argc > 2 ? std::atof(argv[2]) : 5.0;
    const bool waits = !(argc > 3 && std::strcmp(argv[3], "--as-fast-as-possible") == 0);

    char why[512] = "";
    const std::unique_ptr<hierarq_program, Free> program(hierarq_program_load(json.data(), json.size(), why, sizeof why));
    if (!program) return failed(argv[1], why);
    const std::unique_ptr<hierarq_controller, Free> controller(hierarq_controller_new(program.get(), nullptr, why, sizeof why));
    if (!controller) return failed(argv[1], why);

    const std::size_t nq = hierarq_nq(program.get()), nv = hierarq_nv(program.get());
    if (nq != nv) return failed(argv[1], "this loop integrates joints alone");
    std::vector<double> q(nq), velocity(nv);
    hierarq_home(program.get(), q.data(), nq);
    const double period = hierarq_period(program.get());
    const int goal = hierarq_signal_index(program.get(), "goal");
    const int go = hierarq_event_index(program.get(), "go");

    const auto ticks = static_cast<long>(std::lround(seconds / period));
    std::vector<double> took(static_cast<std::size_t>(ticks));
    const auto start = std::chrono::steady_clock::now();
    std::string state;
    for (long k = 0; k < ticks; ++k) {
        const double time = static_cast<double>(k) * period;
        if (waits) std::this_thread::sleep_until(start + std::chrono::duration<double>(time));
        const auto before = std::chrono::steady_clock::now();
        if (goal >= 0) {
            const double value[3] = {0.45, 0.15 * std::sin(time), 0.5};
            hierarq_signal_set(controller.get(), goal, value, 3, time);
        }
        if (k == ticks / 4) hierarq_event_raise(controller.get(), go);
        const hierarq_result result = hierarq_step(controller.get(), time, q.data(), nq, velocity.data(), nv);
        took[static_cast<std::size_t>(k)] = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - before).count();
        if (result != HIERARQ_RESULT_OK) {
            hierarq_fault_text(controller.get(), why, sizeof why);
            std::printf("%.3f s  fault %d: %s\n", time, static_cast<int>(result), why);
        }
        if (state != hierarq_state(controller.get())) {
            state = hierarq_state(controller.get());
            std::printf("%.3f s  state %s\n", time, state.c_str());
        }
        for (std::size_t i = 0; i < nq; ++i) q[i] += period * velocity[i];
    }

    std::printf("q");
    // Hexadecimal digits lose nothing.
    for (const double x : q) std::printf(" %a", x);
    std::printf("\n");
    for (std::size_t i = 0; i < hierarq_task_count(controller.get()); ++i) {
        const char *what = hierarq_task_is_limit(controller.get(), i) ? "margin" : "error";
        std::printf("%s %s %.6f\n", what, hierarq_task_name(controller.get(), i), hierarq_task_value(controller.get(), i));
    }
    std::sort(took.begin(), took.end());
    std::printf("step: median %.1f us, 99 %% %.1f us, worst %.1f us\n", took[took.size() / 2], took[took.size() * 99 / 100], took.back());
    return 0;
}
