import { readdirSync, readFileSync } from 'node:fs';

import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

// A page is a copy of the packages in it: their licences ask for their notices in every copy.
const { dependencies } = JSON.parse(readFileSync(`${__dirname}/package.json`, 'utf8'));
const notices = Object.keys(dependencies).map((name) => {
  const folder = `${__dirname}/node_modules/${name}`;
  const file = readdirSync(folder).find((entry) => /^LICEN[CS]E/.test(entry));
  if (!file) throw new Error(`${folder} has no LICENSE, which every page has to show`);
  return `${name}\n\n${readFileSync(`${folder}/${file}`, 'utf8').trim()}`;
});

// One page a build, for each becomes one file: PAGE is page (runs), study or map, OUT the folder.
export default defineConfig({
  root: __dirname,
  plugins: [viteSingleFile({ removeViteModuleLoader: true })],
  build: {
    target: 'es2022',
    outDir: process.env.OUT ?? 'dist',
    emptyOutDir: false,
    reportCompressedSize: false,
    chunkSizeWarningLimit: 2000,
    rollupOptions: {
      input: `${__dirname}/${process.env.PAGE ?? 'page'}.html`,
      output: { banner: `/*! ${notices.join('\n\n')} */` },
    },
  },
  logLevel: 'warn',
});
