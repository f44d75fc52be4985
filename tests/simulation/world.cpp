#include "tests/simulation/world.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <type_traits>
#include <utility>

namespace coppice::simulation {
namespace {

constexpr std::uint64_t kMostSteps = 20'000'000;

DispatchSettings settings_of(const Scenario& scenario) {
  DispatchSettings settings;
  settings.limits.ahead = scenario.ahead;
  settings.limits.copies = scenario.copies;
  settings.limits.isolate_after = scenario.isolate_after;
  settings.limits.apart_after = scenario.apart_after;
  settings.limits.lost_before_apart = scenario.lost_before_apart;
  settings.cross_check = scenario.cross_check / 1000.0;
  settings.seed = hash(scenario.seed, 2);
  settings.places = scenario.own_processes ? scenario.workers : 0;
  settings.protocol = World::kProtocol;
  settings.golden = 1;
  return settings;
}

}  // namespace

World::World(const Scenario& scenario)
    : scenario_(scenario), dispatcher_(settings_of(scenario)), seats_(scenario.seats()), clients_(scenario.clients) {}

void World::at(Nanos time, What what, std::uint32_t seat, std::uint64_t a, std::uint64_t b, std::uint32_t c,
               std::uint32_t d) {
  const std::uint32_t life = seat < seats_.size() ? seats_[seat].life : 0;
  ahead_.push({std::max(time, now_), order_++, what, seat, life, a, b, c, d});
}

Nanos World::delay(std::uint64_t link) {
  const std::uint64_t draw = hash(scenario_.seed, 3, link, drawn_++);
  // One in a thousand takes its time.
  const auto mean = static_cast<std::uint64_t>(scenario_.delay);
  const std::uint64_t more = draw % 1024 == 0 ? hash(draw) % (mean * 64) : hash(draw) % (mean * 2);
  return scenario_.delay + static_cast<Nanos>(more);
}

bool World::lost(std::uint32_t seat) {
  if (faults_over_ || scenario_.lost == 0) {
    return false;
  }
  return hash(scenario_.seed, 4, seat, drawn_++) % 1'000'000 < scenario_.lost;
}

Report World::run() {
  Nanos last_fault = 0;
  for (std::size_t i = 0; i < scenario_.faults.size(); ++i) {
    const Fault& fault = scenario_.faults[i];
    at(fault.at, What::fault, ~0U, i);
    last_fault = std::max(last_fault, fault.at + fault.lasts);
  }
  at(last_fault + kMillisecond, What::fault_ends, ~0U);
  for (std::uint32_t seat = 0; seat < scenario_.seats(); ++seat) {
    seats_[seat].place = seat;
    const std::uint64_t within = scenario_.at_once ? 1 : 20 * kMillisecond;
    at(static_cast<Nanos>(hash(scenario_.seed, 5, seat) % within), What::process_comes, seat);
  }
  for (std::uint32_t client = 0; client < scenario_.clients; ++client) {
    clients_[client].due = true;
    at(0, What::client, ~0U, client);
  }
  while (!run_over_) {
    if (++report_.steps > kMostSteps) {
      broken("endless", "too many steps");
    }
    Nanos next = ahead_.empty() ? wake_at_ : std::min(wake_at_, ahead_.top().at);
    if (held_up_until_ > now_) {
      next = ahead_.empty() || ahead_.top().at > held_up_until_ ? held_up_until_ : ahead_.top().at;
    }
    now_ = std::max(now_, next);
    while (!ahead_.empty() && ahead_.top().at <= now_) {
      const Happening happening = ahead_.top();
      ahead_.pop();
      happen(happening);
    }
    if (held_up_until_ <= now_ && (!inbox_.empty() || wake_at_ <= now_)) {
      step();
    }
    check_end();
  }
  report_.simulated = now_;
  return report_;
}

void World::happen(const Happening& happening) {
  switch (happening.what) {
    case What::hello:
    case What::answer:
    case What::link:
    case What::process_seen_to_end:
    case What::home_computed:
      if (held_up_until_ > now_) {  // then its steps go on before all that has come meanwhile is read
        Happening again = happening;
        again.at = held_up_until_ + static_cast<Nanos>(hash(scenario_.seed, 18, happening.order) % (50 * kMillisecond));
        ahead_.push(again);
        return;
      }
      hear(happening);
      return;
    case What::fault:
      begin_fault(scenario_.faults[happening.a]);
      return;
    case What::fault_ends:
      end_all_faults();
      return;
    case What::client:
      if (clients_[happening.a].request) {
        add_portion(static_cast<std::uint32_t>(happening.a));
      } else if (!clients_[happening.a].over && clients_[happening.a].due) {
        begin_request(static_cast<std::uint32_t>(happening.a));
      }
      return;
    case What::wake:
      return;
    case What::process_comes:
      come(happening.seat);
      return;
    default:
      break;
  }
  // What follows happens to a process, if it is still there.
  Seat& seat = seats_[happening.seat];
  if (!seat.runs || seat.life != happening.life) {
    return;
  }
  const Nanos delayed = std::max(
      seat.stopped_until, happening.what == What::computed || happening.what == What::task ? seat.hangs_until : 0);
  if (delayed > now_) {
    Happening again = happening;
    again.at = delayed;
    ahead_.push(again);
    return;
  }
  switch (happening.what) {
    case What::hello_due:
      say_hello(happening.seat);
      at(now_ + 250 * kMillisecond, What::hello_due, happening.seat);
      return;
    case What::task:
      take_task(happening);
      return;
    case What::computed:
      finish(happening);
      return;
    case What::chain:
      seat.holds_chain = true;
      say_hello(happening.seat);
      return;
    case What::announced:
      seat.serves = true;
      say_hello(happening.seat);
      return;
    default:
      return;
  }
}

// A deme's next epoch takes in who left its neighbour after the last one.
bool World::may_begin(std::uint32_t index) const {
  if (!is_deme(index)) {
    return true;
  }
  const std::uint32_t demes = std::min(scenario_.demes, scenario_.clients);
  const Client& neighbour = clients_[(index + demes - 1) % demes];
  return neighbour.over || neighbour.number >= clients_[index].number;
}

void World::begin_request(std::uint32_t index) {
  Client& client = clients_[index];
  RequestTerms terms;
  if (is_deme(index)) {
    terms = {.work = {.kind = WorkKind::evolve, .size = scenario_.epoch}, .most_per_batch = 1, .expected = 1};
  } else {
    terms.most_per_batch = 1 + static_cast<std::uint32_t>(hash(scenario_.seed, 6) % 256);
    terms.expected = scenario_.units;
  }
  client.request = dispatcher_.open(terms, time_of(now_));
  if (is_deme(index)) {
    epochs_.insert(*client.request);
  }
  client.due = false;
  client.added = 0;
  if (std::exchange(deadly_to_come_, false)) {
    deadly_ = Unit{*client.request, static_cast<std::uint32_t>(hash(scenario_.seed, 7) % units_of(*client.request))};
  }
  add_portion(index);
}

// The rest comes at once, or when what there is may be done already.
void World::add_portion(std::uint32_t index) {
  Client& client = clients_[index];
  const std::uint32_t units = units_of(*client.request);
  if (client.added == units) {
    return;
  }
  const std::uint32_t portion = std::max(units / scenario_.portions, 1U);
  const std::uint32_t more = std::min(portion, units - client.added);
  client.added += more;
  dispatcher_.add(*client.request, more);
  if (client.added == units) {
    dispatcher_.seal(*client.request);
  } else {
    const std::uint64_t draw = hash(scenario_.seed, 19, *client.request, client.added);
    const auto most = static_cast<std::uint64_t>(4 * scenario_.each * more);
    at(now_ + (draw % 2 == 0 ? 1 : static_cast<Nanos>(draw % most)), What::client, ~0U, index);
  }
  wake_at_ = now_;
}

// What requesters do between two steps: take what is done.
void World::requesters() {
  for (std::uint32_t index = 0; index < clients_.size(); ++index) {
    Client& client = clients_[index];
    if (!client.request) {
      continue;
    }
    const RequestId id = *client.request;
    if (!dispatcher_.done(id)) {
      continue;
    }
    check_taken(id, dispatcher_.take(id));
    ++report_.requests;
    client.request.reset();
    ++client.number;
    open_when_faults_ended_.erase(id);
    // Some go on until all that was open when the faults ended is done: nothing may starve behind them.
    client.over = client.number >= scenario_.requests && open_when_faults_ended_.empty();
  }
  for (std::uint32_t index = 0; index < clients_.size(); ++index) {
    Client& client = clients_[index];
    if (!client.request && !client.over && !client.due && may_begin(index)) {
      client.due = true;
      at(now_ + static_cast<Nanos>(hash(scenario_.seed, 8, index, client.number) % 1000), What::client, ~0U, index);
    }
  }
  run_over_ = run_over_ || std::all_of(clients_.begin(), clients_.end(), [&](const Client& client) {
                return client.over ||
                       (!client.request && client.number >= scenario_.requests && open_when_faults_ended_.empty());
              });
}

// The requesters give everything up and begin again where they were.
void World::give_up() {
  dispatcher_.abandon();
  if (hash(scenario_.seed, 9) % 2 == 0) {
    computing_.clear();  // what was being computed here is cut off; else it comes late
  }
  deadly_.reset();
  open_when_faults_ended_.clear();
  for (std::uint32_t index = 0; index < clients_.size(); ++index) {
    if (std::exchange(clients_[index].request, std::nullopt)) {
      clients_[index].due = true;
      at(now_ + kMicrosecond, What::client, ~0U, index);
    }
  }
}

void World::step() {
  const DispatchStatistics before = dispatcher_.statistics();
  std::vector<DispatchEvent> events = std::exchange(inbox_, {});
  Actions actions = dispatcher_.step(events, time_of(now_));
  wake_at_ = std::chrono::duration_cast<std::chrono::nanoseconds>(actions.wake_at.time_since_epoch()).count();
  if (wake_at_ <= now_) {
    broken("wakes", "the next step is due at once, again and again");
  }
  for (const Action& action : actions.actions) {
    report_.actions_hash = hash(report_.actions_hash, action.index(), now_);
    perform(action);
  }
  if (actions.failure) {
    failed(*actions.failure);
  }
  if (report_.all_ready == 0 && dispatcher_.roster().ready() == scenario_.seats()) {
    report_.all_ready = now_;
  }
  if (!run_over_) {
    check_step(before);
    requesters();
  }
}

void World::perform(const Action& action) {
  std::visit(
      [&](const auto& wanted) {
        using Wanted = std::decay_t<decltype(wanted)>;
        if constexpr (std::is_same_v<Wanted, OpenLink>) {
          if (!links_.emplace(wanted.worker, next_link_).second) {
            broken("links", "opened twice");
          }
          const auto seat = seat_of_.find(wanted.worker);
          if (seat != seat_of_.end()) {
            at(now_ + 15 * kMillisecond + delay(1), What::link, seat->second, static_cast<std::uint64_t>(wanted.worker),
               next_link_);
          }
          ++next_link_;
        } else if constexpr (std::is_same_v<Wanted, CloseLink>) {
          if (links_.erase(wanted.worker) != 1) {
            broken("links", "closed what was not open");
          }
          ++closed_links_;
          const auto seat = seat_of_.find(wanted.worker);
          if (seat != seat_of_.end() && seats_[seat->second].id == wanted.worker && seats_[seat->second].runs &&
              !seats_[seat->second].touched && scenario_.lost == 0) {
            broken("forgotten", "a worker was let go to whom nothing had happened");
          }
        } else if constexpr (std::is_same_v<Wanted, SendTask>) {
          check_sent(wanted);
          const std::uint32_t index = seat_of_.at(wanted.worker);
          Seat& seat = seats_[index];
          last_batch_ = static_cast<std::uint64_t>(wanted.batch.id);
          report_.actions_hash = hash(report_.actions_hash, wanted.batch.id, wanted.batch.first, wanted.batch.count);
          if (seat.id != wanted.worker) {
            return;  // it is gone, and nobody knows yet
          }
          if (!seat.runs) {  // nobody can know whether it ended before or after this came
            for (std::uint32_t i = 0; i < wanted.batch.count; ++i) {
              ++deaths_at_[{wanted.batch.request, wanted.batch.first + i}];
            }
            return;
          }
          seat.sent.push_back(wanted.batch);
          sent_.push_back(wanted.batch);
          if (lost(index) || (cut_off(seat) && hash(scenario_.seed, 10, drawn_++) % 2 == 0)) {
            return;
          }
          const Nanos from = std::max({now_, cut_off(seat) ? seat.cut_off_until : 0, seat.last_task_arrives});
          seat.last_task_arrives = from + delay(index);
          at(seat.last_task_arrives, What::task, index, sent_.size() - 1);
        } else if constexpr (std::is_same_v<Wanted, SendBlocks>) {
          const std::uint32_t index = seat_of_.at(wanted.worker);
          if (!cut_off(seats_[index]) && !lost(index)) {
            at(now_ + delay(index), What::chain, index);
          }
        } else if constexpr (std::is_same_v<Wanted, Announce>) {
          for (std::uint32_t index = 0; index < seats_.size(); ++index) {
            if (seats_[index].runs && !seats_[index].serves && !cut_off(seats_[index])) {
              at(now_ + delay(index), What::announced, index);
            }
          }
        } else if constexpr (std::is_same_v<Wanted, Compute>) {
          compute(wanted);
        } else if constexpr (std::is_same_v<Wanted, StartProcess>) {
          at(now_ + 5 * kMillisecond + delay(2), What::process_comes, static_cast<std::uint32_t>(wanted.place));
        }
      },
      action);
}

void World::compute(const Compute& compute) {
  if (dispatcher_.requests().count(compute.request) == 0) {
    broken("computes", "for a request that nobody has open");
  }
  const auto id = static_cast<std::uint64_t>(compute.id);
  computing_.emplace(id, compute);
  Nanos takes = cost(compute.request, compute.units.size()) + (compute.apart ? kMillisecond : 0);
  const std::uint64_t draw = hash(scenario_.seed, 11, id);
  if (draw % 8 == 0 && !faults_over_) {  // at times the coordinator has little of the processor
    takes += std::min<Nanos>(15 * takes, kSecond);
  }
  at(now_ + (draw % 4 == 0 ? takes : 1), What::home_computed, ~0U, id);
}

void World::hear(const Happening& happening) {
  switch (happening.what) {
    case What::hello:
      inbox_.emplace_back(hello_of(happening));
      return;
    case What::answer:
      hear_answer(happening);
      return;
    case What::link: {
      const Seat& seat = seats_[happening.seat];
      const WorkerId worker{happening.a};
      const auto link = links_.find(worker);
      if (link == links_.end() || link->second != happening.b || seat.id != worker || !seat.runs) {
        return;
      }
      if (cut_off(seat)) {
        at(std::max(seat.cut_off_until, all_cut_off_until_) + 15 * kMillisecond, What::link, happening.seat,
           happening.a, happening.b);
        return;
      }
      inbox_.emplace_back(LinkChanged{worker, true});
      return;
    }
    case What::process_seen_to_end:
      inbox_.emplace_back(ProcessEnded{happening.seat, static_cast<pid_t>(happening.a), happening.c != 0, "it ended"});
      return;
    case What::home_computed: {
      const auto found = computing_.find(happening.a);
      if (found == computing_.end()) {
        return;
      }
      const Compute compute = std::move(found->second);
      computing_.erase(found);
      Computed computed{compute.id, std::chrono::nanoseconds(scenario_.each), {}, {}};
      for (const std::uint32_t unit : compute.units) {
        computed.outcomes.push_back(truth(compute.request, unit));
        if (compute.apart && deadly_everywhere_ && deadly_ == Unit{compute.request, unit}) {
          computed.died = "it died";
        }
      }
      apart_done_ += compute.apart && computed.died.empty() ? 1 : 0;
      inbox_.emplace_back(std::move(computed));
      return;
    }
    default:
      return;
  }
}

// The answer is to what was sent, whatever the coordinator holds under that number by now.
void World::hear_answer(const Happening& happening) {
  AnswerHeard heard;
  const Batch batch = sent_[happening.a];
  heard.worker = WorkerId{happening.b};
  heard.origin = origin_of(happening.seat, happening.life);
  heard.batch = batch.id;
  heard.kind = static_cast<AnswerHeard::Kind>(happening.c);
  heard.elapsed = std::chrono::nanoseconds(cost(batch.request, batch.count));
  const auto out = dispatcher_.find(heard.batch, heard.worker);
  if (out) {
    if (heard.kind == AnswerHeard::Kind::no_memory) {
      count_shortage(happening.seat);
    }
    std::erase_if(seats_[happening.seat].sent, [&](const Batch& sent) { return sent.id == heard.batch; });
  }
  if (heard.kind == AnswerHeard::Kind::computed && out && out->current &&
      dispatcher_.listens_to(heard.worker, heard.origin)) {
    if (out->batch.count != batch.count) {
      broken("answers", "a late one is taken for one to another batch");
    }
    for (std::uint32_t i = 0; i < batch.count; ++i) {
      const bool lies = happening.d == 1 || (happening.d == 2 && i == 0);
      heard.outcomes.push_back(lies ? lie(batch.request, batch.first + i, heard.worker)
                                    : truth(batch.request, batch.first + i));
    }
  }
  inbox_.emplace_back(std::move(heard));
}

void World::failed(const Failure& failure) {
  report_.actions_hash = hash(report_.actions_hash, failure.error.kind);
  check_failure(failure);
  if (failure.error.kind == ErrorKind::revoked) {
    lies_taken_.clear();
  }
  if (failure.deadly) {
    report_.stopped_by_deadly_unit = true;
    run_over_ = true;
  } else if (scenario_.own_processes && dispatcher_.processes() == 0) {
    run_over_ = true;
  } else {
    give_up();
  }
}

}  // namespace coppice::simulation
