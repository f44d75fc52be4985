// The studio on the network of this machine: the gate, the page, and the session behind it. Pure but for the session.
#pragma once

#include <string>

#include "coordinator/studio/http_server.hpp"
#include "coordinator/studio/studio_gate.hpp"
#include "coordinator/studio/studio_session.hpp"

namespace coppice {

// GET / is the page, POST /api/NAME asks the session. Anything else is refused and says nothing about the study.
// Thread rule: as StudioSession.
HttpResponse answer_of(const StudioGate& gate, StudioSession& session, const HttpRequest& request);

}  // namespace coppice
