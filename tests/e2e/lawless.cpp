// Access control of DDS for one who does not heed it: the plugin that comes with DDS, but that it allows its own
// participant everything. With it a program that holds a worker's true identity creates writers and readers of whatever
// it likes, so that only the other side's rules are left to stop it: what the tests want to see. DDS loads it where a
// configuration names it (usurp.cpp).
#include <cstring>
#include <dds/security/dds_security_api_access_control.h>
#include <dlfcn.h>

namespace {

using Init = int (*)(const char* argument, void** context, struct ddsi_domaingv* domain);
using Finalize = int (*)(void* context);

void* original = nullptr;
DDS_Security_access_control_get_permissions_credential_token true_credential = nullptr;

// Rights of one's own making, of the same length, under the signature of the true ones.
DDS_Security_boolean edited_credential(dds_security_access_control* instance,
                                       DDS_Security_PermissionsCredentialToken* token,
                                       DDS_Security_PermissionsHandle handle, DDS_Security_SecurityException* why) {
  constexpr const char* kSigned = "  <default>DENY</default>";
  constexpr const char* kWanted = " <default>ALLOW</default>";
  if (true_credential(instance, token, handle, why) == 0) {
    return 0;
  }
  for (DDS_Security_unsigned_long i = 0; i < token->properties._length; ++i) {
    char* document = token->properties._buffer[i].value;
    while ((document = std::strstr(document, kSigned)) != nullptr) {
      std::memcpy(document, kWanted, std::strlen(kWanted));
    }
  }
  return 1;
}

int allow_everything(const char* argument, void** context, struct ddsi_domaingv* domain) {
  original = dlopen(COPPICE_ACCESS_CONTROL, RTLD_NOW | RTLD_LOCAL);
  const auto init = original == nullptr ? nullptr : reinterpret_cast<Init>(dlsym(original, "init_access_control"));
  if (init == nullptr || init(argument, context, domain) != 0) {
    return 1;
  }
  auto* const rules = static_cast<dds_security_access_control*>(*context);
  rules->check_create_datawriter = [](auto...) -> DDS_Security_boolean { return 1; };
  rules->check_create_datareader = [](auto...) -> DDS_Security_boolean { return 1; };
  rules->check_create_topic = [](auto...) -> DDS_Security_boolean { return 1; };
  rules->check_remote_participant = [](auto...) -> DDS_Security_boolean { return 1; };
  rules->check_remote_datawriter = [](auto...) -> DDS_Security_boolean { return 1; };
  rules->check_remote_datareader = [](dds_security_access_control*, DDS_Security_PermissionsHandle,
                                      DDS_Security_DomainId, const DDS_Security_SubscriptionBuiltinTopicDataSecure*,
                                      DDS_Security_boolean* relay_only,
                                      DDS_Security_SecurityException*) -> DDS_Security_boolean {
    *relay_only = 0;
    return 1;
  };
  return 0;
}

}  // namespace

extern "C" {

__attribute__((visibility("default"))) int init_lawless(const char* argument, void** context,
                                                        struct ddsi_domaingv* domain) {
  return allow_everything(argument, context, domain);
}

// Besides, tells others of rights that nobody signed.
__attribute__((visibility("default"))) int init_forger(const char* argument, void** context,
                                                       struct ddsi_domaingv* domain) {
  if (allow_everything(argument, context, domain) != 0) {
    return 1;
  }
  auto* const rules = static_cast<dds_security_access_control*>(*context);
  true_credential = rules->get_permissions_credential_token;
  rules->get_permissions_credential_token = &edited_credential;
  return 0;
}

__attribute__((visibility("default"))) int finalize_lawless(void* context) {
  return reinterpret_cast<Finalize>(dlsym(original, "finalize_access_control"))(context);
}

}  // extern "C"
