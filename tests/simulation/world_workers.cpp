// Workers, their processes and strangers, as the simulation plays them: what serve.cpp and lane.cpp do, as far as the
// coordinator can see it.
#include <algorithm>
#include <fmt/format.h>

#include "tests/simulation/world.hpp"

namespace coppice::simulation {
namespace {

constexpr Nanos kLonely = 1500 * kMillisecond;  // away for so long, a worker lets go of the run

// Flags of a Hello on its way.
constexpr std::uint32_t kServes = 1;
constexpr std::uint32_t kHoldsChain = 2;
constexpr std::uint32_t kLeaving = 4;
constexpr std::uint32_t kStranger = 8;  // with an origin of his own
constexpr std::uint32_t kNobody = 16;   // without an origin
constexpr std::uint32_t kOtherBuild = 32;

}  // namespace

Origin World::origin_of(std::uint32_t seat, std::uint32_t life) const {
  Origin origin{};
  const std::uint64_t number = hash(seat, life);
  std::copy_n(reinterpret_cast<const std::uint8_t*>(&number), sizeof number, origin.begin());
  return origin;
}

void World::come(std::uint32_t index) {
  Seat& seat = seats_[index];
  if (seat.runs) {
    return;
  }
  Seat fresh;
  fresh.life = seat.life + 1;
  fresh.place = seat.place;
  fresh.fake = seat.fake;
  fresh.other_build = seat.other_build;
  fresh.runs = true;
  fresh.cut_off_until = seat.cut_off_until;
  fresh.slow_until = seat.slow_until;
  fresh.slowness = seat.slowness;
  fresh.touched = seat.touched;
  fresh.lies = seat.lies;
  fresh.id = WorkerId{(hash(scenario_.seed, 12, index, fresh.life) << 1U) | 1U};
  fresh.lanes.resize(scenario_.lanes);
  seat = std::move(fresh);
  seat_of_[seat.id] = index;
  if (!honest(index)) {
    liars_.insert(seat.id);
  }
  if (scenario_.own_processes && index < scenario_.workers) {
    inbox_.emplace_back(ProcessStarted{seat.place, static_cast<pid_t>(1 + index + 4096 * seat.life)});
  }
  at(now_ + delay(index), What::announced, index);
  at(now_ + delay(index), What::hello_due, index);
}

void World::die(std::uint32_t index, bool in_order) {
  Seat& seat = seats_[index];
  if (!seat.runs) {
    return;
  }
  seat.runs = false;
  for (const Batch& batch : seat.sent) {
    for (std::uint32_t unit = batch.first; !in_order && unit < batch.first + batch.count; ++unit) {
      ++deaths_at_[{batch.request, unit}];
    }
  }
  if (scenario_.own_processes && index < scenario_.workers) {
    at(now_ + static_cast<Nanos>(hash(scenario_.seed, 13, index, seat.life) % (100 * kMillisecond)),
       What::process_seen_to_end, index, 1 + index + 4096 * std::uint64_t{seat.life}, 0, in_order ? 1 : 0);
  } else if (!seat.fake && !faults_over_) {
    at(std::max(now_ + kMillisecond, seat.absent_until), What::process_comes, index);
  } else if (!seat.fake) {
    at(now_ + kMillisecond, What::process_comes, index);
  }
}

void World::say_hello(std::uint32_t index, bool leaving) {
  Seat& seat = seats_[index];
  if (seat.serves && !seat.holds_chain && !cut_off(seat) && !seat.fake) {
    inbox_.emplace_back(BlocksAsked{seat.id, origin_of(index, seat.life), 0, 16});
  }
  if (cut_off(seat) || lost(index)) {
    return;
  }
  at(now_ + delay(index), What::hello, index, seat.evaluated, static_cast<std::uint64_t>(seat.id),
     (seat.serves ? kServes : 0) | (seat.holds_chain ? kHoldsChain : 0) | (leaving ? kLeaving : 0) |
         (seat.other_build ? kOtherBuild : 0));
}

HelloHeard World::hello_of(const Happening& happening) const {
  HelloHeard heard;
  heard.worker = WorkerId{happening.b};
  heard.origin = origin_of(happening.seat, happening.life);
  if ((happening.c & kStranger) != 0) {
    heard.origin = origin_of(~0U, 0);
  } else if ((happening.c & kNobody) != 0) {
    heard.origin.reset();
  }
  heard.protocol = (happening.c & kOtherBuild) != 0 && happening.seat % 2 == 0 ? kProtocol + 1 : kProtocol;
  heard.golden = (happening.c & kOtherBuild) != 0 ? 2 : 1;
  // On another host, a process may have the number of one of ours.
  const std::uint32_t like = happening.seat % scenario_.workers;
  heard.pid =
      static_cast<pid_t>(1 + like + 4096 * (happening.seat < scenario_.workers ? happening.life : seats_[like].life));
  heard.here = scenario_.own_processes && happening.seat < scenario_.workers;
  heard.lanes = scenario_.lanes;
  heard.evaluated = happening.a;
  heard.leaving = (happening.c & kLeaving) != 0;
  heard.serves = (happening.c & kServes) != 0;
  heard.holds_chain = heard.serves && (happening.c & kHoldsChain) != 0;
  return heard;
}

bool World::deadly(const Batch& batch) const {
  return deadly_ && deadly_->request == batch.request && deadly_->index >= batch.first &&
         deadly_->index < batch.first + batch.count;
}

void World::take_task(const Happening& happening) {
  Seat& seat = seats_[happening.seat];
  const std::size_t batch = happening.a;
  if (seat.dies_in_phase == 1) {
    die(happening.seat, false);
    return;
  }
  if (!seat.holds_chain) {
    answer(happening.seat, batch, AnswerHeard::Kind::chain_unknown, 0);
    return;
  }
  seat.queue.push_back(batch);
  work(happening.seat);
}

void World::work(std::uint32_t index) {
  Seat& seat = seats_[index];
  for (std::uint32_t lane = 0; lane < seat.lanes.size() && seat.runs; ++lane) {
    while (!seat.lanes[lane].batch && !seat.queue.empty()) {
      const std::size_t place = seat.queue.front();
      const Batch batch = sent_[place];
      seat.queue.pop_front();
      if (seat.short_until > now_ && batch.count > seat.short_above) {
        answer(index, place, AnswerHeard::Kind::no_memory, 0);
        continue;
      }
      seat.lanes[lane].batch = place;
      ++seat.lanes[lane].turn;
      const Nanos takes =
          cost(batch.request, batch.count) * static_cast<Nanos>(seat.slow_until > now_ ? seat.slowness : 1);
      const bool dies = seat.dies_in_phase == 2 || deadly(batch);
      at(now_ + (dies ? takes / 2 : takes), What::computed, index, lane, seat.lanes[lane].turn, dies ? 1 : 0);
    }
  }
}

void World::finish(const Happening& happening) {
  Seat& seat = seats_[happening.seat];
  Lane& lane = seat.lanes[happening.a];
  if (!lane.batch || lane.turn != happening.b) {
    return;
  }
  if (happening.c != 0 || seat.dies_in_phase == 3) {
    die(happening.seat, false);
    return;
  }
  const std::size_t place = *lane.batch;
  const Batch batch = sent_[place];
  lane.batch.reset();
  seat.evaluated += batch.count;
  std::uint32_t lies = 0;
  const bool seldom = hash(scenario_.seed, 14, batch.id) % 16 == 0;
  if (seat.lies == 1 || (seat.lies == 2 && seldom) || (seat.lies == 3 && !seat.lied)) {
    lies = seat.lies == 1 ? 1 : 2;
    seat.lied = true;
  }
  const bool damaged = std::exchange(seat.damages, false) || (seat.fake && seat.lies == 4);
  if (!(seat.fake && seat.lies == 5)) {  // who never answers
    answer(happening.seat, place, damaged ? AnswerHeard::Kind::damaged : AnswerHeard::Kind::computed, lies);
  }
  work(happening.seat);
}

void World::answer(std::uint32_t index, std::size_t batch, AnswerHeard::Kind kind, std::uint32_t lies) {
  const Seat& seat = seats_[index];
  if (lost(index) || (cut_off(seat) && hash(scenario_.seed, 15, drawn_++) % 2 == 0)) {
    return;
  }
  const Nanos from = cut_off(seat) ? std::max(seat.cut_off_until, all_cut_off_until_) : now_;
  const bool twice = scenario_.doubled > 0 && hash(scenario_.seed, 16, drawn_++) % 1'000'000 < scenario_.doubled;
  for (int copy = 0; copy < (twice ? 2 : 1); ++copy) {
    at(from + delay(index), What::answer, index, batch, static_cast<std::uint64_t>(seat.id),
       static_cast<std::uint32_t>(kind), lies);
  }
}

void World::begin_fault(const Fault& fault) {
  using Kind = Fault::Kind;
  const std::uint32_t index = fault.target % scenario_.seats();
  const Nanos end = now_ + fault.lasts;
  Seat& seat = seats_[index];
  switch (fault.kind) {
    case Kind::crash:
      seat.touched = true;
      seat.absent_until = end;
      seat.dies_in_phase = fault.detail;
      if (fault.detail == 0) {
        die(index, false);
      }
      return;
    case Kind::pause:
      seat.touched = true;
      seat.stopped_until = std::max(seat.stopped_until, end);
      return;
    case Kind::slow:
      seat.touched = true;
      seat.slow_until = end;
      seat.slowness = fault.detail;
      return;
    case Kind::cut_off:
      seat.touched = true;
      seat.cut_off_until = std::max(seat.cut_off_until, end);
      if (fault.lasts > kLonely) {
        seat.serves = false;
      }
      return;
    case Kind::all_cut_off:
      all_cut_off_until_ = std::max(all_cut_off_until_, end);
      for (Seat& each : seats_) {
        each.touched = true;
        each.serves = each.serves && fault.lasts <= kLonely;
      }
      return;
    case Kind::all_crash:
      for (std::uint32_t each = 0; each < scenario_.seats(); ++each) {
        seats_[each].touched = true;
        seats_[each].absent_until = end;
        die(each, false);
      }
      return;
    case Kind::leave:
      seat.touched = true;
      if (seat.runs) {
        for (const std::size_t batch : seat.queue) {
          answer(index, batch, AnswerHeard::Kind::given_back, 0);
        }
        for (const Lane& lane : seat.lanes) {
          if (lane.batch) {
            answer(index, *lane.batch, AnswerHeard::Kind::given_back, 0);
          }
        }
        say_hello(index, true);
        seat.absent_until = end;
        die(index, true);
      }
      return;
    case Kind::hang:
      seat.touched = true;
      seat.hangs_until = std::max(seat.hangs_until, end);
      return;
    case Kind::forget_chain:
      seat.touched = true;
      seat.holds_chain = false;
      return;
    case Kind::lack_memory:
      seat.touched = true;
      seat.short_until = end;
      seat.short_above = fault.detail;
      return;
    case Kind::lie:
      seat.touched = true;
      seat.lies = 1 + fault.detail % 3;
      if (seat.runs) {
        liars_.insert(seat.id);
      }
      return;
    case Kind::damage:
      seat.touched = true;
      seat.damages = true;
      if (seat.runs) {
        liars_.insert(seat.id);
      }
      return;
    case Kind::coordinator_held_up:
      held_up_until_ = std::max(held_up_until_, end);
      return;
    case Kind::abandon:
      give_up();
      return;
    case Kind::false_hello:
    case Kind::false_farewell:
      // Of workers that the coordinator has shown: else nobody knows the name.
      if (dispatcher_.roster().speaker(seat.id, origin_of(index, seat.life)) == Roster::Speaker::own) {
        const std::uint32_t flags = (fault.detail % 2 == 0 ? kStranger : kNobody) | kServes | kHoldsChain |
                                    (fault.kind == Kind::false_farewell ? kLeaving : 0);
        for (Nanos when = now_; when < end && when < now_ + 10 * kSecond; when += 100 * kMillisecond) {
          at(when, What::hello, index, when % 97, static_cast<std::uint64_t>(seat.id), flags);
        }
      }
      return;
    case Kind::false_answer:
      for (std::uint64_t batch = last_batch_ > 8 ? last_batch_ - 8 : 0; batch < last_batch_ + 8; ++batch) {
        AnswerHeard heard;
        heard.worker = seat.id;
        heard.batch = BatchId{batch};
        heard.kind = static_cast<AnswerHeard::Kind>(fault.detail);
        if (fault.detail % 2 == 0) {
          heard.origin = origin_of(~0U, 0);
        }
        if (dispatcher_.roster().speaker(seat.id, origin_of(index, seat.life)) == Roster::Speaker::own) {
          inbox_.emplace_back(std::move(heard));
        }
      }
      return;
    case Kind::fake_worker:
    case Kind::other_build: {
      Seat fake;
      fake.fake = fault.kind == Kind::fake_worker;
      fake.other_build = !fake.fake;
      fake.lies = fake.fake ? 4 + fault.detail % 2 : 0;
      fake.touched = true;
      seats_.push_back(fake);
      at(now_, What::process_comes, static_cast<std::uint32_t>(seats_.size() - 1));
      return;
    }
    case Kind::deadly_unit:
      deadly_to_come_ = true;
      deadly_everywhere_ = fault.detail == 0;
      return;
  }
}

// From now on everybody is there, honest and quick.
void World::end_all_faults() {
  faults_over_ = true;
  faults_over_at_ = now_;
  held_up_until_ = now_;
  all_cut_off_until_ = now_;
  deadly_to_come_ = false;
  for (std::uint32_t index = 0; index < seats_.size(); ++index) {
    Seat& seat = seats_[index];
    seat.stopped_until = seat.cut_off_until = seat.slow_until = seat.hangs_until = seat.short_until = now_;
    seat.dies_in_phase = 0;
    seat.damages = false;
    if (seat.fake || seat.other_build) {
      seat.runs = false;
      continue;
    }
    if (seat.runs && liars_.count(seat.id) != 0) {  // its process is replaced by an honest one
      seat.absent_until = now_;
      die(index, false);
    }
    seat.lies = 0;  // before it comes
    if (!scenario_.own_processes || index >= scenario_.workers) {
      at(now_, What::process_comes, index);
    }
  }
  for (const Client& client : clients_) {
    if (client.request) {
      open_when_faults_ended_.insert(*client.request);
    }
  }
}

}  // namespace coppice::simulation
