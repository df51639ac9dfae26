# The explorer for a class: docker build -t ido-explorer . && docker run -p 8080:8080 ido-explorer
# It prints an address with a token; see assets/docs/class.md.
FROM python:3.12-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends libgl1 libgomp1 libx11-6 \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /explorer
COPY . .
RUN pip install --no-cache-dir . && useradd --create-home explorer
USER explorer
EXPOSE 8080
CMD ["ido-viz", "--host", "0.0.0.0", "--port", "8080", "--no-open"]
