// The identity of a program under DDS Security: a folder of six files, made by deploy/security/make-certificates.sh.
// The plugins of DDS read it themselves; what they would pass over in silence (a key that is another certificate's
// never meets anybody, and says nothing) is looked for here first.
#pragma once

#include <filesystem>

#include "common/error.hpp"

namespace coppice::wire {

inline constexpr const char* kIdentityAuthority = "identity_ca.pem";        // whose certificates are believed
inline constexpr const char* kPermissionsAuthority = "permissions_ca.pem";  // whose signature the next two carry
inline constexpr const char* kGovernance = "governance.smime";              // what is protected, and how
inline constexpr const char* kPermissions = "permissions.smime";            // who may read and write which topics
inline constexpr const char* kCertificate = "certificate.pem";
inline constexpr const char* kPrivateKey = "key.pem";

// Errors name the file: one that cannot be read, a certificate that the authority did not sign or whose time is over
// or has not come, a key that does not belong to it.
Result<void> check_credentials(const std::filesystem::path& folder);

}  // namespace coppice::wire
