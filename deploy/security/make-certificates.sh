#!/usr/bin/env bash
# Makes all that DDS Security needs, with OpenSSL: authorities, an identity for coordinators, one for workers, and signed
# rules of who may read and write what.
#   deploy/security/make-certificates.sh DIR [--days N]
# DIR/coordinator and DIR/worker are what `--security` takes: copy each to the hosts that play that part. DIR/authority
# holds the keys that make identities: keep it off those hosts. An existing DIR/authority is used again, so that another
# run renews the identities and rules.
set -euo pipefail
umask 077

days=825
folder=
while [ $# -gt 0 ]; do
  case $1 in
    --days) days=${2:-}; shift ;;
    -h | --help) sed -n '2,7s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) echo "make-certificates.sh: no option '$1': expected --days" >&2; exit 2 ;;
    *) folder=$1 ;;
  esac
  shift
done
case $days in '' | *[!0-9]*) echo "make-certificates.sh: --days '$days': expected a number" >&2; exit 2 ;; esac
[ -n "$folder" ] || { echo "usage: make-certificates.sh DIR [--days N]" >&2; exit 2; }

authority=$folder/authority
mkdir -p "$authority" "$folder/coordinator" "$folder/worker"

new_key() { openssl genpkey -algorithm EC -pkeyopt ec_paramgen_curve:prime256v1 -out "$1" 2>/dev/null; }

for name in identity_ca permissions_ca; do
  [ -e "$authority/$name.pem" ] && continue
  new_key "$authority/$name.key"
  openssl req -x509 -new -key "$authority/$name.key" -sha256 -days 3650 -subj "/O=Coppice/CN=$name" \
    -out "$authority/$name.pem"
done

for role in coordinator worker; do
  new_key "$folder/$role/key.pem"
  openssl req -new -key "$folder/$role/key.pem" -sha256 -subj "/O=Coppice/CN=$role" |
    openssl x509 -req -CA "$authority/identity_ca.pem" -CAkey "$authority/identity_ca.key" -CAcreateserial \
      -CAserial "$authority/identity_ca.srl" -sha256 -days "$days" -out "$folder/$role/certificate.pem" 2>/dev/null
done

# Everything that leaves a participant is encrypted (rtps_protection_kind); one layer is enough, each costs as much again.
cat > "$authority/governance.xml" <<XML
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>ENCRYPT</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>NONE</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
XML

topics() { for topic in "$@"; do printf '<topic>%s</topic>' "$topic"; done; }
grant() { # role, topics to publish, topics to subscribe
  local subject
  subject=$(openssl x509 -in "$folder/$1/certificate.pem" -noout -subject -nameopt RFC2253)
  cat <<XML
    <grant name="$1">
      <subject_name>${subject#subject=}</subject_name>
      <validity><not_before>$(date -u -d '1 day ago' +%Y-%m-%dT%H:%M:%S)</not_before><not_after>$(date -u -d "+$days days" +%Y-%m-%dT%H:%M:%S)</not_after></validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>230</max></id_range></domains>
        <publish><topics>$2</topics><partitions><partition>*</partition></partitions></publish>
        <subscribe><topics>$3</topics><partitions><partition>*</partition></partitions></subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
XML
}
# idl/README.md: who writes which topic. The version in a name is left open: programs of two versions refuse each other.
from_coordinator=$(topics coppice_Control coppice_Fleet 'coppice_v*_Task' 'coppice_v*_ChainBlock')
from_worker=$(topics coppice_Hello 'coppice_v*_Answer' 'coppice_v*_ChainRequest')
{
  echo '<?xml version="1.0" encoding="UTF-8"?>'
  echo '<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
  echo '     xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">'
  echo '  <permissions>'
  # `coppice workers`, with a coordinator's identity, also listens to coordinators.
  grant coordinator "$from_coordinator" "$from_worker$(topics coppice_Control coppice_Fleet)"
  grant worker "$from_worker" "$(topics coppice_Control 'coppice_v*_Task' 'coppice_v*_ChainBlock')"
  echo '  </permissions>'
  echo '</dds>'
} > "$authority/permissions.xml"

for rules in governance permissions; do
  openssl smime -sign -in "$authority/$rules.xml" -text -out "$authority/$rules.smime" \
    -signer "$authority/permissions_ca.pem" -inkey "$authority/permissions_ca.key"
done
for role in coordinator worker; do
  cp "$authority"/{identity_ca.pem,permissions_ca.pem,governance.smime,permissions.smime} "$folder/$role/"
done
echo "$folder/coordinator and $folder/worker are ready for --security, for $days days; keep $folder/authority to yourself."
