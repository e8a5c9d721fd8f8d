// Foxglove's schemas, with which files and live messages are compared.
import { createRequire } from 'node:module';
import { check } from './verdict.mjs';

const require = createRequire(import.meta.url);
const protobuf = require('protobufjs');
const { FileDescriptorSet } = require('protobufjs/ext/descriptor');
const { foxgloveEnumSchemas, foxgloveMessageSchemas, generateProto } =
  require('@foxglove/schemas/internal');

/** Foxglove's schemas as they publish them. */
export function published() {
  const root = new protobuf.Root();
  for (const name of ['timestamp', 'duration']) {
    root.addJSON(protobuf.common.get(`google/protobuf/${name}.proto`).nested);
  }
  for (const [name, schema] of Object.entries(foxgloveMessageSchemas)) {
    const enums = Object.values(foxgloveEnumSchemas).filter((e) => e.parentSchemaName === name);
    protobuf.parse(generateProto(schema, enums), root, { keepCase: true });
  }
  root.resolveAll();
  return root;
}

const fieldsOf = (type) => type.fieldsArray.map((f) => `${f.repeated ? 'repeated ' : ''}${
  f.resolvedType?.fullName ?? f.type} ${f.name} = ${f.id}`).sort().join('; ');
const valuesOf = (type) => type.nestedArray.filter((n) => n.values)
  .map((n) => `${n.name} ${JSON.stringify(n.values)}`).join('; ');

/** All message types that a type is made of, itself among them. */
function reached(type, all = new Set()) {
  if (all.has(type)) return all;
  all.add(type);
  for (const field of type.fieldsArray) {
    field.resolve();
    if (field.resolvedType?.fieldsArray) reached(field.resolvedType, all);
  }
  return all;
}

/** The message type of a schema: its FileDescriptorSet in `data`. Its parts must be Foxglove's. */
export function typeOf(schema, official) {
  check(`${schema.name}: is protobuf`, schema.encoding === 'protobuf');
  const root = protobuf.Root.fromDescriptor(FileDescriptorSet.decode(schema.data));
  root.resolveAll();
  const type = root.lookupType(schema.name);
  for (const part of reached(type)) {
    if (!part.fullName.startsWith('.foxglove.')) continue;
    const theirs = official.lookupType(part.fullName.slice(1));
    check(`${part.fullName}: the fields are Foxglove's`, fieldsOf(part) === fieldsOf(theirs),
      `${fieldsOf(part)} / ${fieldsOf(theirs)}`);
    check(`${part.fullName}: the enumerations are Foxglove's`, valuesOf(part) === valuesOf(theirs));
  }
  return type;
}

/** A message as an object. */
export const plain = (type, data) =>
  type.toObject(type.decode(data), { longs: Number, bytes: Array });
