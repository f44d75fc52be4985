// The comparison for dispatch: the same trees, kernel and codec as `coppice bench`, but over MPI, and chunked by hand:
// each rank evaluates an equal share of a generation, rank 0 its own as well; trees and tallies travel each generation.
// Every tally is compared with the serial one.
//   mpirun -np 2 mpi_evaluation [REPETITIONS]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mpi.h>
#include <vector>

#include "common/fitness/evaluation.hpp"
#include "common/wire/codec.hpp"
#include "coordinator/bench/workload.hpp"
#include "coordinator/learning/learn.hpp"

namespace {

using namespace coppice;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kEpisodes = 50'000;  // as `coppice bench` learns its chain

std::shared_ptr<const Chain> learned_chain() {
  const auto world = load_world("uav");
  LearnSettings settings = default_settings(world->kind, Algorithm::q_learning);
  settings.episodes = kEpisodes;
  return std::make_shared<const Chain>(std::move(learn(*world, settings, [](std::uint64_t) { return true; })->chain));
}

// One rank's kernel.
class Kernel {
 public:
  explicit Kernel(const std::shared_ptr<const PreparedChain>& chain) : chain_(chain) {}

  std::vector<Tally> evaluate(std::span<const Tree> trees, const Job& job) {
    job_ = std::move(*PreparedJob::make(chain_, job, job_));
    evaluation_ ? evaluation_->begin(job_) : static_cast<void>(evaluation_.emplace(job_));
    return evaluation_->evaluate(trees);
  }

 private:
  std::shared_ptr<const PreparedChain> chain_;
  std::shared_ptr<const PreparedJob> job_;
  std::optional<Evaluation> evaluation_;
};

void send(const std::vector<std::uint8_t>& bytes, int to) {
  MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, to, 0, MPI_COMM_WORLD);
}

std::vector<std::uint8_t> receive(int from) {
  MPI_Status status;
  MPI_Probe(from, 0, MPI_COMM_WORLD, &status);
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  MPI_Recv(bytes.data(), size, MPI_BYTE, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return bytes;
}

// Until an empty message comes.
void serve(Kernel& kernel, const Vocabulary& vocabulary) {
  wire::TaskDecoder decoder(vocabulary);
  while (true) {
    const auto task = receive(0);
    if (task.empty()) {
      return;
    }
    const auto decoded = decoder.decode(task);
    send(wire::encode_tallies(kernel.evaluate(decoded->trees, decoded->job)), 0);
  }
}

std::vector<Tally> evaluate_over(int ranks, Kernel& kernel, std::span<const Tree> trees, const Job& job) {
  const auto begin_of = [&](int rank) {
    return trees.size() * static_cast<std::size_t>(rank) / static_cast<std::size_t>(ranks);
  };
  for (int rank = 1; rank < ranks; ++rank) {
    send(wire::encode_task(job, trees.subspan(begin_of(rank), begin_of(rank + 1) - begin_of(rank))), rank);
  }
  std::vector<Tally> tallies = kernel.evaluate(trees.first(begin_of(1)), job);
  for (int rank = 1; rank < ranks; ++rank) {
    auto some = wire::decode_tallies(receive(rank), begin_of(rank + 1) - begin_of(rank), job.objectives.size());
    std::move(some->begin(), some->end(), std::back_inserter(tallies));
  }
  return tallies;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
  return values[values.size() / 2];
}

void measure(int ranks, int repetitions, Kernel& kernel, const std::vector<Workload>& workloads) {
  std::printf("%-8s %12s %12s %8s\n", "workload", "serial us", "MPI us", "ratio");
  for (const Workload& workload : workloads) {
    std::vector<double> serial;
    std::vector<double> over;
    std::vector<double> ratios;
    for (int repetition = 0; repetition <= repetitions; ++repetition) {
      double seconds[2] = {};
      for (std::uint32_t i = 0; i < workload.generations; ++i) {
        const Job job = workload.job_of(static_cast<std::uint32_t>(repetition) * workload.generations + i);
        const auto begin = Clock::now();
        const auto expected = kernel.evaluate(workload.trees, job);
        const auto middle = Clock::now();
        const auto got = evaluate_over(ranks, kernel, workload.trees, job);
        seconds[0] += std::chrono::duration<double>(middle - begin).count();
        seconds[1] += std::chrono::duration<double>(Clock::now() - middle).count();
        if (got != expected) {
          std::fprintf(stderr, "mpi_evaluation: %s: other tallies than the serial path\n", workload.name.c_str());
          MPI_Abort(MPI_COMM_WORLD, 1);
        }
      }
      if (repetition > 0) {
        serial.push_back(1e6 * seconds[0] / workload.generations);
        over.push_back(1e6 * seconds[1] / workload.generations);
        ratios.push_back(seconds[0] / seconds[1]);
      }
    }
    std::printf("%-8s %12.0f %12.0f %8.2f\n", workload.name.c_str(), median(serial), median(over), median(ratios));
  }
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank = 0;
  int ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const auto chain = learned_chain();
  Kernel kernel(PreparedChain::make(chain));
  if (rank == 0) {
    measure(ranks, argc > 1 ? std::atoi(argv[1]) : 9, kernel, standard_workloads(*chain));
    for (int other = 1; other < ranks; ++other) {
      send({}, other);
    }
  } else {
    serve(kernel, chain->vocabulary());
  }
  MPI_Finalize();
  return 0;
}
